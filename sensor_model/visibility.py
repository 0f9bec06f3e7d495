"""Visible faces of each actor, and points that lie off its outline."""

import math

import numpy as np

from luxloop.arrays import Bytes, Floats
from luxloop.sensor_model.bodies.scene import Bodies
from luxloop.sensor_model.kernels.outlines import count_on_faces, label_echoes
from luxloop.sensor_model.kernels.records import OutlinedBodies
from luxloop.sensor_model.raycaster import Echoes
from luxloop.sensor_model.returns import Returns
from luxloop.sensor_model.truth import Cause, Face, View

MIN_FACE_HITS = 3
"""Minimum number of points of a visible face."""
MAX_CLEAN_DEPTH = 0.20
"""Largest depth of a clean point inside the outline of its body in plan [m]; an estimate.

The outline has the drawn body's bows and corners. The edges of hoods lie 0.12 m behind the bumper (mean of the drawn
proportions), and twice the standard deviation of the relief is 0.06 m. Windows, hoods and interiors that a higher
beam meets are deeper."""

_MIN_FACING = math.cos(math.radians(30.0))  # a cut corner, at 45 degrees, belongs to neither of its faces
_FACES = np.array([Face.FRONT, Face.LEFT, Face.REAR, Face.RIGHT], dtype=np.uint8)


def from_surfaces(echoes: Echoes, bodies: Bodies) -> Returns:
    """Label each echo with part and cause."""
    part, cause, point = label_echoes(
        echoes.target, echoes.surface, echoes.point_body, bodies.plane_part, _outlined(bodies), MAX_CLEAN_DEPTH
    )
    return Returns(
        beam=echoes.beam,
        range=echoes.range,
        width=echoes.width,
        power=echoes.power,
        target=echoes.target,
        surface=echoes.surface,
        part=part,
        cause=cause,
        point_body=point,
        flags=np.zeros(len(part), dtype=np.uint16),
    )


def visible_faces(returns: Returns, unit: Bytes, origin_ego: Floats, bodies: Bodies, size: Floats) -> Bytes:
    """Return the (A,) `Face` bits of the faces with at least `MIN_FACE_HITS` clean points.

    A point is on a face if its surface and the nearest edge of the outline face that way; the tread of a wheel faces
    forward too. The LIDAR must be in front of the face: from abreast, only the bowed edge of a rear is visible.

    Parameters
    ----------
    unit
        (N,) unit of each return.
    origin_ego
        (U, 3) positions of the units in the ego frame [m].
    size
        (A, 3) length, width, height [m].
    """
    count = count_on_faces(
        returns.cause == Cause.CLEAN, returns.target, returns.surface, returns.point_body, unit, origin_ego,
        _outlined(bodies), size, _MIN_FACING,
    )  # fmt: skip
    faces: Bytes = np.bitwise_or.reduce(np.where(count >= MIN_FACE_HITS, _FACES, np.uint8(0)), axis=1)
    return faces


def _outlined(bodies: Bodies) -> OutlinedBodies:
    return OutlinedBodies(
        bodies.pose_ego, bodies.planes_body, bodies.plane_turn, bodies.plane_pivot, bodies.body_outline, bodies.outline
    )


def view_kind(faces: Bytes) -> Bytes:
    """Return the (A,) `View` of visible faces; an L-shape has an end and a side."""
    return _VIEW[faces]


def _view(faces: int) -> View:
    end, side = faces & (Face.FRONT | Face.REAR), faces & (Face.LEFT | Face.RIGHT)
    if end and side:
        return View.L_SHAPE
    if side:
        return View.SIDE
    if end:
        return View.REAR if faces & Face.REAR else View.FRONT
    return View.NONE


_VIEW = np.array([_view(faces) for faces in range(16)], dtype=np.uint8)
