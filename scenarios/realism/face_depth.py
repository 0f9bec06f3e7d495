"""Depth of points behind the visible faces of a labelled box."""

from dataclasses import dataclass

import numpy as np

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.realism.labelled_vehicle import LabelledVehicle

NEAR_M = 0.60
"""[m] Depth of the points that place a face."""
CLEAR_M = 0.25
"""[m] Their least distance from the ends of the face, which excludes points of the next face."""
NEAR_POINTS_MIN = 5
"""Least number of these points; with fewer, the face stays at the label."""
SKIN_PERCENTILE = 10.0
"""Percentile of their depths that becomes depth 0, so that errors of the label's position do not count."""

NORMALS = np.array([(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])
"""Outward normals of front, rear, left and right in the frame of the box."""


@dataclass(frozen=True, slots=True, eq=False)
class Face:
    """A visible face with all points of its vehicle."""

    end: bool
    """True for a front or rear, False for a flank."""
    along: Floats
    """(N,) coordinate of each point along the face, from its middle [m]."""
    depth: Floats
    """(N,) distance of each point behind the face, positive inside [m]."""


def visible_faces(vehicle: LabelledVehicle) -> list[Face]:
    """Return the faces in front of whose planes a LIDAR with points on the vehicle is, moved onto the points."""
    half = 0.5 * vehicle.box[3:]
    points, lidars = vehicle.points_box, vehicle.lidars_box
    return [_placed(points, normal, half) for normal in NORMALS if (lidars @ normal > np.abs(normal) @ half).any()]


def least_depth(faces: list[Face]) -> Floats:
    """Return the depth (N,) of each point behind the visible face that it is nearest to the outside of [m]."""
    depth: Floats = np.min([face.depth for face in faces], axis=0)
    return depth


def _placed(points: Floats, normal: Floats, half: Floats) -> Face:
    """Return a face moved to the 10th percentile of the depths of the points near it; unmoved if these are too few."""
    axis = np.abs(normal)
    depth, along = axis @ half - points @ normal, points @ axis[::-1]
    near = depth[(depth < NEAR_M) & (np.abs(along) < axis[::-1] @ half - CLEAR_M)]
    skin = np.percentile(near, SKIN_PERCENTILE) if len(near) >= NEAR_POINTS_MIN else 0.0
    return Face(end=bool(axis[0]), along=along, depth=depth - skin)
