"""An articulated truck as two boxes: one rectangle does not describe it while it is bent."""

import numpy as np

from scenarios.arrays import Floats, Ints
from scenarios.grading.plane_geometry import turned
from sim.articulation import hitch


def trailers(pose: Floats, size: Floats) -> tuple[Floats, Floats]:
    """Poses (N, 3) and sizes of the trailers of N trucks.

    Parameters
    ----------
    pose
        (N, 3) of the straight trucks' boxes, in any frame.
    size
        (N, 2) or (N, 3) of them, the length first [m].
    """
    front = hitch(size[:, 0]).trailer_front
    return _ahead(pose, -0.5 * front), _as_long_as(size, size[:, 0] - front)


def tractors(pose: Floats, size: Floats, articulation: Floats) -> tuple[Floats, Floats]:
    """Poses and sizes of what is before the trailers, turned about the kingpins by `articulation` (N,) [rad]."""
    places = hitch(size[:, 0])
    kingpin = _ahead(pose, 0.5 * size[:, 0] - places.kingpin)
    kingpin[:, 2] += articulation
    return _ahead(kingpin, places.kingpin - 0.5 * places.trailer_front), _as_long_as(size, places.trailer_front)


def parts(pose: Floats, size: Floats, articulation: Floats) -> tuple[Ints, Floats, Floats]:
    """Boxes that show N vehicles: row of the vehicle, pose and size of each; first one for each, then the tractors."""
    bent = np.flatnonzero(articulation)
    poses, sizes = pose.copy(), size.copy()
    poses[bent], sizes[bent] = trailers(pose[bent], size[bent])
    tractor_pose, tractor_size = tractors(pose[bent], size[bent], articulation[bent])
    return np.append(np.arange(len(pose)), bent), np.vstack([poses, tractor_pose]), np.vstack([sizes, tractor_size])


def _ahead(pose: Floats, distance: Floats) -> Floats:
    """Poses (N, 3) moved along their headings by distances (N,) [m]."""
    moved = pose.copy()
    moved[:, :2] += turned(np.column_stack([distance, np.zeros_like(distance)]), pose[:, 2])
    return moved


def _as_long_as(size: Floats, length: Floats) -> Floats:
    return np.column_stack([length, size[:, 1:]])
