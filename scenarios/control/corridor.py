"""Who is ahead: the nearest that reaches into the strip which the ego will sweep if it keeps turning as it does."""

from dataclasses import dataclass

import numpy as np

from scenarios.arrays import Floats
from scenarios.control.surroundings import Surroundings
from scenarios.grading.plane_geometry import CORNER_SIGNS, corner

_SLOWEST = 1.0
"""[m/s] A slower ego's yaw rate tells no curvature: it is divided by this speed at least."""
_STRAIGHT = 1e-6
"""[1/m] A path of less curvature is straight."""


@dataclass(frozen=True, slots=True)
class Lead:
    """The vehicle ahead."""

    id: int
    """Of its track, or of the actor."""
    gap: float
    """[m] from the ego's front bumper to the nearest of it inside the corridor, along the path; negative in a crash."""
    speed: float
    """[m/s] along the path."""


def lead_of(around: Surroundings, half_width_m: float) -> Lead | None:
    """Return who is ahead in a corridor of this half width [m], or None. Ahead is whose centre is."""
    curvature = around.yaw_rate / max(abs(around.speed), _SLOWEST)
    center = along_path(around.boxes_ego[:, :2], curvature)
    corners = along_path(corner(around.boxes_ego[:, None], CORNER_SIGNS), curvature)
    near = np.where(center[:, 0] > 0, nearest_inside(corners, half_width_m), np.inf)
    if not np.isfinite(near).any():
        return None
    row = int(np.argmin(near))
    course = curvature * center[row, 0]
    speed = float(around.velocity_ego[row] @ (np.cos(course), np.sin(course)))
    return Lead(int(around.id[row]), float(near[row]) - around.front_m, speed)


def along_path(points_ego: Floats, curvature: float) -> Floats:
    """Points (..., 2) [m] as (way along the path, offset to its left) from the ego's centre.

    The path is the arc of a curvature [1/m], positive to the left: with k s its direction after the way s, a point at
    the offset d is at x = sin(k s) (1/k - d), y = 1/k - cos(k s) (1/k - d).
    """
    if abs(curvature) < _STRAIGHT:
        return points_ego
    sine, cosine = curvature * points_ego[..., 0], 1.0 - curvature * points_ego[..., 1]
    return np.stack([np.arctan2(sine, cosine), 1.0 - np.hypot(sine, cosine)], axis=-1) / curvature


def nearest_inside(corners: Floats, half_width_m: float) -> Floats:
    """Least way (N,) along the path at which outlines (N, 4, 2) touch the strip; infinite for those that do not.

    It is at a corner inside the strip, or where an edge crosses one of its borders.
    """
    after = np.roll(corners, -1, axis=1)
    way, offset = corners[..., 0], corners[..., 1]
    at = [np.where(np.abs(offset) <= half_width_m, way, np.inf)]
    rise = after[..., 1] - offset
    for border in (-half_width_m, half_width_m):
        part = (border - offset) / np.where(rise == 0, np.nan, rise)
        crosses = (part >= 0) & (part <= 1)
        at.append(np.where(crosses, way + np.where(crosses, part, 0.0) * (after[..., 0] - way), np.inf))
    return np.asarray(np.min(at, axis=(0, 2)))
