"""Visible faces of each actor, and points that lie off its outline."""

import numpy as np

from sensor_model.arrays import Bytes, Floats, Ints
from sensor_model.bodies.scene import Bodies
from sensor_model.raycaster import Echoes
from sensor_model.returns import GROUND, Returns
from sensor_model.truth import Cause, Face, Part, View
from sim.world import Actors

MIN_FACE_HITS = 3
"""Minimum number of points of a visible face."""
MAX_CLEAN_DEPTH = 0.20
"""Maximum depth of a point on the outline inside it [m]. Rounded corners are at most 0.18 m deep."""

_MIN_FACING = np.cos(np.deg2rad(30.0))  # a cut corner, at 45 degrees, belongs to neither of its faces
_SIDES = ((Face.FRONT, 0, 1.0), (Face.LEFT, 1, 1.0), (Face.REAR, 0, -1.0), (Face.RIGHT, 1, -1.0))
"""Each face, the body axis it faces along, and the direction."""


def from_surfaces(echoes: Echoes, bodies: Bodies, actors: Actors) -> Returns:
    """Label each echo with part and cause."""
    target, surface = echoes.target, echoes.surface
    part = np.where(target == GROUND, Part.GROUND, Part.OBSTACLE).astype(np.uint8)
    cause = np.full(len(target), Cause.CLEAN, dtype=np.uint8)
    on_actor = np.flatnonzero(target >= 0)
    part[on_actor] = bodies.plane_part[surface[on_actor]]
    points_body = echoes.point_body[:, :2].copy()
    points_body[on_actor] = bodies.straight_points(target[on_actor], surface[on_actor], points_body[on_actor])
    cause[on_actor] = point_causes(part[on_actor], points_body[on_actor], actors.size[target[on_actor]])
    return Returns(
        beam=echoes.beam,
        range=echoes.range,
        width=echoes.width,
        power=echoes.power,
        target=target,
        surface=surface,
        part=part,
        cause=cause,
        point_body=points_body,
        flags=np.zeros(len(target), dtype=np.uint16),
    )


def point_causes(part: Bytes, points_body: Floats, size: Floats) -> Bytes:
    """Return the (N,) `Cause` of points that lie on actors.

    Parameters
    ----------
    part
        (N,) `Part`.
    points_body
        (N, 2) true points in the frame of their actor, with articulation removed [m].
    size
        (N, 3) length, width, height of their actor [m].
    """
    depth = 0.5 * size[:, :2] - np.abs(points_body)
    inside = (depth[:, 0] > MAX_CLEAN_DEPTH) & (depth[:, 1] > MAX_CLEAN_DEPTH)
    cause = np.zeros(len(part), dtype=np.uint8)  # Cause.CLEAN
    cause[inside] = Cause.LAYER_OVERLAP
    cause[part == Part.MIRROR] = Cause.MIRROR
    return cause


def visible_faces(
    actor: Ints, normal_body: Floats, points_body: Floats, lidar_body: Floats, size: Floats, actors: int
) -> Bytes:
    """Return the (A,) `Face` bits of the faces with at least `MIN_FACE_HITS` points.

    A point is on a face if its surface faces that way and it lies at that side; the tread of a wheel faces forward too.
    The LIDAR must be in front of the face: from abreast, only the bowed edge of a rear is visible.

    Parameters
    ----------
    actor
        (N,) actor of each point on an outline.
    normal_body
        (N, 3) outward normal of the surface, in the actor's frame; at corners the position alone is ambiguous.
    lidar_body
        (N, 2) position of the LIDAR of each point in that frame [m].
    points_body, size
        (N, 2) points in that frame, and (N, 3) sizes of their actors [m]; with articulation removed.
    actors
        Number of actors A.
    """
    faces = np.zeros(actors, dtype=np.uint8)
    for face, axis, side in _SIDES:
        faces_out = side * normal_body[:, axis] > _MIN_FACING
        at_side = 0.5 * size[:, axis] - side * points_body[:, axis] <= MAX_CLEAN_DEPTH
        in_front = side * lidar_body[:, axis] > 0.5 * size[:, axis]
        count = np.bincount(actor[faces_out & at_side & in_front], minlength=actors)
        faces[count >= MIN_FACE_HITS] |= np.uint8(face)
    return faces


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
