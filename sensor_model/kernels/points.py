"""Positions and directions of echoes in the frames of the bodies they are on."""

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats, Ints
from luxloop.compiled import kernel
from luxloop.sensor_model.kernels.motion import body_at, ego_at
from luxloop.sensor_model.kernels.records import Beams, BodyTilts, EgoDrive, Units


@kernel()
def points_on_bodies(
    beam: Ints, unit: Ints, distance: Floats, target: Ints, beams: Beams, units: Units, motion: Floats,
    tilts: BodyTilts, drive: EgoDrive,
) -> Floats:  # fmt: skip
    """Return points and beam directions of N echoes in the frames of their bodies at the firing time.

    The points are on the centres of the beams.

    Parameters
    ----------
    beam, distance, target
        (N,) row of the beam table, range [m], and body; negative without a body.
    unit
        (B,) unit of each beam.
    motion
        As in `records.Solids`.

    Returns
    -------
    (2, N, 3) points [m] and unit directions; zero for points that are not on a body.
    """
    points = np.zeros((2, len(beam), 3))
    for e in range(len(beam)):
        a, b = target[e], beam[e]
        if a < 0:
            continue
        u = unit[b]
        t = beams.time[b]
        ca, sa, ce, se = beams.direction[b, 0], beams.direction[b, 1], beams.direction[b, 2], beams.direction[b, 3]
        R = units.rotation[u]
        forward = ce * (R[0, 0] * ca + R[0, 1] * sa) + se * R[0, 2]
        left = ce * (R[1, 0] * ca + R[1, 1] * sa) + se * R[1, 2]
        up = ce * (R[2, 0] * ca + R[2, 1] * sa) + se * R[2, 2]
        x, y = units.origin[u, 0] + distance[e] * forward, units.origin[u, 1] + distance[e] * left
        cos, sin = elementary.cos(drive.yaw_rate * t), elementary.sin(drive.yaw_rate * t)
        (ego_x, ego_y), (body_x, body_y) = ego_at(drive, t), body_at(motion, a, t)
        dx, dy = ego_x + cos * x - sin * y - body_x, ego_y + sin * x + cos * y - body_y
        forward, left = cos * forward - sin * left, sin * forward + cos * left
        cos, sin = elementary.cos(motion[a, 2] + motion[a, 7] * t), elementary.sin(motion[a, 2] + motion[a, 7] * t)
        points[0, e, 0], points[0, e, 1] = cos * dx + sin * dy, cos * dy - sin * dx
        points[0, e, 2] = units.origin[u, 2] + distance[e] * up
        points[1, e, 0], points[1, e, 1] = cos * forward + sin * left, cos * left - sin * forward
        points[1, e, 2] = up
        points[0, e, 2] -= tilts.ground_z[a]
        R = tilts.R_level_body[a]
        if R[0, 0] != 1.0 or R[1, 1] != 1.0:
            _rotate_back(R, points[0, e])
            _rotate_back(R, points[1, e])
    return points


@kernel()
def _rotate_back(R: Floats, v: Floats) -> None:
    """Rotate a vector (3,) by the inverse of a rotation (3, 3), in place."""
    x, y, z = v[0], v[1], v[2]
    for axis in range(3):
        v[axis] = R[0, axis] * x + R[1, axis] * y + R[2, axis] * z
