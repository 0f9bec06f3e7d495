"""Parts of staged scenes as tables of a scenario file: road users, moving screen, wall; and constants of all scenes."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from luxloop.arrays import Bools, Floats
from luxloop.sensor_model.rig.rig import Mount, Rig, load_rig
from luxloop.sim.scripted.motions import Motion

Json = dict[str, Any]
Size = tuple[float, float, float]

RIG = "srx_six_lux"
CAR_M: Size = (4.6, 1.8, 1.5)
"""[m] Length, width and height of the target vehicle."""
WALL_HEIGHT_M = 4.0

START = np.array([-6.0, 9.0, 0.0])
"""Start pose (x [m], y [m], yaw [rad]) of a car two lanes to the left of the ego: it shows its front and its side."""
OCCLUDER_Y_M = 4.0
"""[m] Lateral position of the wall or screen, in the ego frame."""
BEFORE_S, AFTER_S = 3.0, 3.5
"""[s] Time in view before and after the occlusion: enough to confirm a track, and to reacquire the car."""
MEMORY_S = 4.5
"""[s] `grading.memory_s`, above its default of 3 s: the time partly hidden adds to the time fully hidden."""


@cache
def scene_rig() -> Rig:
    """Return the rig that the scenes are built for; its files are read once."""
    return load_rig(RIG, Path())


def car(start: Floats, motions: Sequence[Motion]) -> Json:
    """Return the target vehicle, starting at a pose (3,); without motions it is stationary."""
    return road_user("car", "car", start, CAR_M, motions)


def screen(start: Floats, length_m: float, motions: Sequence[Motion]) -> Json:
    """Return a thin moving occluder, as high as a wall; it is not graded."""
    return road_user("screen", "obstacle", start, (length_m, 0.2, WALL_HEIGHT_M), motions)


def wall(corners_m: list[list[float]]) -> Json:
    """Return a thin stationary wall between two points."""
    return {"kind": "wall", "corners_m": corners_m, "height_m": WALL_HEIGHT_M}


def motion_table(motion: Motion) -> Json:
    """Return the table of a motion."""
    return {key: value for key, value in asdict(motion).items() if value is not None}


def road_user(name: str, kind: str, start: Floats, size_m: Size, motions: Sequence[Motion] = ()) -> Json:
    """Return an actor that starts at a pose (3,); without motions it is stationary."""
    place = {"x_m": float(start[0]), "y_m": float(start[1]), "yaw_deg": math.degrees(start[2])}
    drive = {"motion": [motion_table(motion) for motion in motions]} if motions else {}
    return {"name": name, "kind": kind, **place, "size_m": list(size_m), **drive}


_ALONG = np.linspace(-0.5, 0.5, 11)
_EDGE = np.full_like(_ALONG, 0.5)
_SIDES = ((_ALONG, _EDGE), (_ALONG, -_EDGE), (_EDGE, _ALONG), (-_EDGE, _ALONG))
_UNIT_BOX = np.concatenate([np.column_stack(side) for side in _SIDES])
"""Points (44, 2) along the sides of a box of 1 m by 1 m."""


def outline(pose: Floats, size_m: Sequence[float]) -> Floats:
    """Return points (44, 2) [m] along the four sides of a box (length, width, height) at a pose (3,), with corners."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    turned: Floats = (_UNIT_BOX * size_m[:2]) @ np.array([[cos, sin], [-sin, cos]]) + pose[:2]
    return turned


def shadow_on_line(rig: Rig, points_ego: Floats, line_y_m: float) -> tuple[float, float]:
    """Return the interval of x at which the line y = `line_y_m` intersects rays from the LIDARs to points behind it.

    Parameters
    ----------
    rig
        Only LIDARs whose field of view contains a point count for it.
    points_ego
        (N, 2) points in the ego frame [m].
    line_y_m
        Position of the line, left of the ego, in the ego frame [m].

    Returns
    -------
    tuple of float
        Lowest and highest x of the intersections, in the ego frame [m].
    """
    low_m, high_m = shadows_on_line(rig, points_ego[None], line_y_m)[0].tolist()
    return low_m, high_m


def shadows_on_line(rig: Rig, points_ego: Floats, line_y_m: float) -> Floats:
    """Return `shadow_on_line` (T, 2) [m] for each of T times, from the points (T, N, 2) [m] at these times."""
    low_m, high_m = np.full(len(points_ego), np.inf), np.full(len(points_ego), -np.inf)
    for mount in rig.mounts:
        at = _position(rig, mount)
        ray = points_ego - at
        with np.errstate(divide="ignore", invalid="ignore"):  # rays outside the field of view may be parallel
            x_m = at[0] + ray[..., 0] * (line_y_m - at[1]) / ray[..., 1]
        seen = _in_field_of_view(mount, ray)
        low_m = np.minimum(low_m, np.where(seen, x_m, np.inf).min(axis=1))
        high_m = np.maximum(high_m, np.where(seen, x_m, -np.inf).max(axis=1))
    return np.column_stack([low_m, high_m])


def screen_end(rig: Rig, points_ego: Floats, line_y_m: float, share: float) -> float:
    """Return the x [m] to which a screen on the line must reach, from its rear end, to hide a share of the points.

    The share is that of the angle under which the LIDARs see the points, summed over the LIDARs: their beams are evenly
    spaced in angle. `rig`, `points_ego` and `line_y_m` are as for `shadow_on_line`.
    """
    spans = [(at, np.arctan2(ray[:, 1], ray[:, 0])) for at, ray in _rays(rig, points_ego) if len(ray)]
    whole = sum(float(np.ptp(bearing)) for _, bearing in spans)

    def visible(end_m: float) -> float:
        """Return the visible angle [rad] in front of the screen's end."""
        ends = [(math.atan2(line_y_m - at[1], end_m - at[0]), bearing) for at, bearing in spans]
        return sum(float(np.clip(end, bearing.min(), bearing.max()) - bearing.min()) for end, bearing in ends)

    left_m, right_m = shadow_on_line(rig, points_ego, line_y_m)
    return float(
        scipy.optimize.brentq(lambda end_m: visible(end_m) - (1.0 - share) * whole, left_m - 0.1, right_m + 0.1)
    )


def _rays(rig: Rig, points_ego: Floats) -> Iterator[tuple[Floats, Floats]]:
    """Yield the position (2,) of each LIDAR, and the rays (N, 2) from it to the points in its field of view."""
    for mount in rig.mounts:
        at = _position(rig, mount)
        yield at, (points_ego - at)[_in_field_of_view(mount, points_ego - at)]


def _position(rig: Rig, mount: Mount) -> Floats:
    """Return the position (2,) of a LIDAR in the ego frame [m]."""
    return np.array([mount.x_m + rig.rear_axle_x_m, mount.y_m])


def _in_field_of_view(mount: Mount, ray: Floats) -> Bools:
    """(...) mask of rays (..., 2) from a LIDAR that are in its field of view."""
    azimuth_deg = (np.degrees(np.arctan2(ray[..., 1], ray[..., 0])) - mount.yaw_deg + 180.0) % 360.0 - 180.0
    left_deg = max(fan.start_deg for fan in mount.model.fans)
    right_deg = min(fan.stop_deg for fan in mount.model.fans)
    inside: Bools = (right_deg <= azimuth_deg) & (azimuth_deg <= left_deg)
    return inside
