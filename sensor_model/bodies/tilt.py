"""Tilt of bodies by pitch and roll about the point of the road under their pose, and the height of that road.

N bodies have attitudes (N, 2), as in `sim.world.Actors`. The axes of the level frame are those of the body without
pitch and roll.
"""

import numpy as np

from sensor_model.arrays import Floats


def tilt_rotations(attitude: Floats) -> Floats:
    """Return (N, 3, 3) rotations R of attitudes (N, 2): level = R body, first pitch about y, then roll about x."""
    (cp, cr), (sp, sr) = np.cos(attitude).T, np.sin(attitude).T
    zero = np.zeros_like(cp)
    rows = [[cp, sp * sr, sp * cr], [zero, cr, -sr], [-sp, cp * sr, cp * cr]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def tilt_planes(planes: Floats, rotation: Floats, ground_z: Floats) -> Floats:
    """Tilt planes (N, 4), normal and offset, by rotations (N, 3, 3), and raise them by heights (N,) [m].

    A point p moves to R p + (0, 0, z), so n . p = d becomes (R n) . p = d + (R n) . (0, 0, z).
    """
    tilted = planes.copy()
    tilted[:, :3] = np.einsum("nij,nj->ni", rotation, planes[:, :3])
    tilted[:, 3] += tilted[:, 2] * ground_z
    return tilted


def tilt_boxes(boxes: Floats, rotation: Floats, ground_z: Floats) -> Floats:
    """Return axis-aligned boxes (N, 2, 3), lower and upper corner, around the tilted and raised boxes."""
    # The half extent along an axis is the sum of those of the box times the rotation's absolute values.
    centre, half = boxes.mean(axis=1), 0.5 * (boxes[:, 1] - boxes[:, 0])
    centre = np.einsum("nij,nj->ni", rotation, centre)
    centre[:, 2] += ground_z
    half = np.einsum("nij,nj->ni", np.abs(rotation), half)
    return np.stack([centre - half, centre + half], axis=1)


def depth_below_road(boxes: Floats, attitude: Floats) -> Floats:
    """Return the (N,) rise of the highest corner of the bottom of boxes (N, 2, 3), which stand on the road [m].

    A solid that is extended downwards by this still reaches a level road.
    """
    reach = np.abs(boxes[:, :, :2]).max(axis=1)
    rise: Floats = (reach * np.abs(np.tan(attitude))).sum(axis=1)
    return rise
