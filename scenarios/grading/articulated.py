"""Articulated trucks and buses as two boxes: while one is bent, one rectangle does not describe it.

A bus has a front part and a rear part in place of tractor and trailer.
"""

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from scenarios.arrays import Floats, Ints
from scenarios.grading.plane_geometry import turned
from sim.articulation import hitch
from sim.world import Kind

Kinds = npt.NDArray[np.uint8] | None
"""`Kind` of each vehicle."""


def trailers(pose: Floats, size: Floats, kind: Kinds = None) -> tuple[Floats, Floats]:
    """Return poses (N, 3) and sizes of the trailers of N trucks.

    Parameters
    ----------
    pose
        (N, 3) poses of the straight trucks' boxes, in any frame [m, m, rad].
    size
        (N, 2) or (N, 3) sizes of these boxes, length first [m].
    kind
        (N,) `Kind`; default: trucks.
    """
    front = hitch(size[:, 0], kind).trailer_front
    return _moved_ahead(pose, -0.5 * front), _with_length(size, size[:, 0] - front)


def tractors(pose: Floats, size: Floats, articulation: Floats, kind: Kinds = None) -> tuple[Floats, Floats]:
    """Return poses (N, 3) and sizes of the tractors, rotated about the kingpins by `articulation` (N,) [rad].

    Parameters
    ----------
    pose, size, kind
        As for `trailers`.
    """
    places = hitch(size[:, 0], kind)
    kingpin = _moved_ahead(pose, 0.5 * size[:, 0] - places.kingpin)
    kingpin[:, 2] += articulation
    return _moved_ahead(kingpin, places.kingpin - 0.5 * places.trailer_front), _with_length(size, places.trailer_front)


def parts(pose: Floats, size: Floats, articulation: Floats, kind: Kinds = None) -> tuple[Ints, Floats, Floats]:
    """Return boxes that show N vehicles: vehicle row, pose and size of each.

    The first N are the vehicles, bent trucks as their trailers; the tractors of the bent trucks follow.
    """
    bent = np.flatnonzero(articulation)
    poses, sizes = pose.copy(), size.copy()
    kinds = None if kind is None else kind[bent]
    poses[bent], sizes[bent] = trailers(pose[bent], size[bent], kinds)
    tractor_pose, tractor_size = tractors(pose[bent], size[bent], articulation[bent], kinds)
    return np.append(np.arange(len(pose)), bent), np.vstack([poses, tractor_pose]), np.vstack([sizes, tractor_size])


def kinds_of(names: Iterable[str]) -> npt.NDArray[np.uint8]:
    """Return the `Kind` of each name in a table of the truth."""
    return np.array([Kind[name.upper()] for name in names], np.uint8)


def _moved_ahead(pose: Floats, distance: Floats) -> Floats:
    """Move poses (N, 3) along their headings by distances (N,) [m]."""
    moved = pose.copy()
    moved[:, :2] += turned(np.column_stack([distance, np.zeros_like(distance)]), pose[:, 2])
    return moved


def _with_length(size: Floats, length: Floats) -> Floats:
    return np.column_stack([length, size[:, 1:]])
