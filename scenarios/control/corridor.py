"""Lead vehicle: the nearest object in the corridor that the ego will cover at its present curvature."""

from dataclasses import dataclass

import numpy as np

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.control.surroundings import Surroundings
from luxloop.scenarios.grading.plane_geometry import CORNER_SIGNS, corner

_MIN_SPEED = 1.0
"""[m/s] Lower bound of the speed in curvature = yaw rate / speed, which is undefined at standstill."""
_STRAIGHT = 1e-6
"""[1/m] Curvature below which the path is taken as straight."""


@dataclass(frozen=True, slots=True)
class LeadVehicle:
    """The lead vehicle."""

    id: int
    """Id of its track, or of the actor."""
    gap: float
    """[m] Gap along the path, from the ego's front bumper to its nearest point in the corridor; negative in a crash."""
    speed: float
    """[m/s] Speed along the path."""


def find_lead(around: Surroundings, half_width_m: float) -> LeadVehicle | None:
    """Return the lead vehicle in a corridor of this half width [m], or None.

    Only objects whose centre is in front of the ego's centre are considered.
    """
    curvature = around.yaw_rate / max(abs(around.speed), _MIN_SPEED)
    center = to_path_frame(around.boxes_ego[:, :2], curvature)
    corners = to_path_frame(corner(around.boxes_ego[:, None], CORNER_SIGNS), curvature)
    near = np.where(center[:, 0] > 0, nearest_in_corridor(corners, half_width_m), np.inf)
    if not np.isfinite(near).any():
        return None
    row = int(np.argmin(near))
    path_heading = curvature * center[row, 0]
    speed = float(around.velocity_ego[row] @ (np.cos(path_heading), np.sin(path_heading)))
    return LeadVehicle(int(around.id[row]), float(near[row]) - around.front_m, speed)


def to_path_frame(points_ego: Floats, curvature: float) -> Floats:
    """Return points (..., 2) [m] as (arc length along the path, offset to its left) from the ego's centre.

    The path is an arc of constant curvature k [1/m], positive to the left. A point with arc length s and offset d is at
    x = sin(k s) (1/k - d), y = 1/k - cos(k s) (1/k - d).
    """
    if abs(curvature) < _STRAIGHT:
        return points_ego
    sine, cosine = curvature * points_ego[..., 0], 1.0 - curvature * points_ego[..., 1]
    return np.stack([np.arctan2(sine, cosine), 1.0 - np.hypot(sine, cosine)], axis=-1) / curvature


def nearest_in_corridor(corners: Floats, half_width_m: float) -> Floats:
    """Return the smallest arc length (N,) of outlines (N, 4, 2) inside the corridor; infinite for those outside.

    The minimum is at a corner inside the corridor, or where an edge crosses one of its borders.
    """
    after = np.roll(corners, -1, axis=1)
    arc, offset = corners[..., 0], corners[..., 1]
    at = [np.where(np.abs(offset) <= half_width_m, arc, np.inf)]
    rise = after[..., 1] - offset
    for border in (-half_width_m, half_width_m):
        part = (border - offset) / np.where(rise == 0, np.nan, rise)
        crosses = (part >= 0) & (part <= 1)
        at.append(np.where(crosses, arc + np.where(crosses, part, 0.0) * (after[..., 0] - arc), np.inf))
    return np.asarray(np.min(at, axis=(0, 2)))
