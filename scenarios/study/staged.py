"""Scenes that are staged to a measure: functions that make a scenario, as a file holds it, of a few numbers.

A study names one as `scenarios.study.staged:hidden_behind_wall` and varies its parameters by their names. Any function
of a team's own will do as well: parameters in, document out, ValueError for what cannot be staged.
"""

import math
from pathlib import Path
from typing import Any, Literal

import numpy as np
from scipy.optimize import brentq

from sensor_model.rig import load_rig

Json = dict[str, Any]
Manoeuvre = Literal["keeps speed", "brakes", "changes lane"]

RIG = "srx_six_lux"
CAR_M = [4.6, 1.8, 1.5]
WALL_Y_M, WALL_HEIGHT_M = 4.0, 4.0
ROAD_Y_M = 9.0
"""[m] Of the car's centre, beside the standing ego; the wall stands between."""
SEEN_BEFORE_S, SEEN_AFTER_S = 3.0, 3.5
"""[s] The car is in view before and after; a track is remembered for up to 3 s (`grading.memory_s`)."""
LANE_M = 3.5
BRAKING_MPS2, SIDEWAYS_MPS2 = 2.0, 2.0
"""[m/s^2] Comfortable, so that nobody in sight would have been warned."""


def hidden_behind_wall(occlusion_s: float, speed_mps: float, manoeuvre: Manoeuvre = "keeps speed") -> Json:
    """A car drives past the standing ego and is hidden by a wall; what it does there is not seen.

    The wall is as long as it takes: no LIDAR of the rig can see any of the car for `occlusion_s`.

    Parameters
    ----------
    occlusion_s
        How long nothing of the car can be seen [s].
    speed_mps
        Its speed when it disappears [m/s].
    manoeuvre
        It keeps its speed; brakes with 2 m/s^2, down to half its speed at most; or changes to the lane farther off, as
        far as 2 m/s^2 sideways take it in that time.

    Raises
    ------
    ValueError
        There is no such manoeuvre, or a number is not positive.
    """
    if not (occlusion_s > 0 and speed_mps > 0):
        raise ValueError(f"occlusion_s = {occlusion_s:g} and speed_mps = {speed_mps:g} must be positive")
    hidden, way_m = _hidden_motion(occlusion_s, speed_mps, manoeuvre)
    before = {"kind": "straight", "speed_mps": speed_mps, "duration_s": SEEN_BEFORE_S}
    wall_m = _wall_length(way_m + CAR_M[0])
    start_m, _ = umbra(wall_m)
    first_m = start_m + 0.5 * CAR_M[0]  # of the car's centre, when its rear end disappears
    return {
        "description": f"A car at {speed_mps:g} m/s is hidden by a wall for {occlusion_s:g} s and {manoeuvre} meanwhile.",
        "duration_s": SEEN_BEFORE_S + occlusion_s + SEEN_AFTER_S,
        "traffic": {
            "kind": "scripted",
            "actor": [
                {
                    "name": "car",
                    "x_m": first_m - speed_mps * SEEN_BEFORE_S,
                    "y_m": ROAD_Y_M,
                    "size_m": CAR_M,
                    "motion": [before, *hidden],
                }
            ],
            "obstacle": [_wall([[-0.5 * wall_m, WALL_Y_M], [0.5 * wall_m, WALL_Y_M]])],
        },
    }


def _hidden_motion(occlusion_s: float, speed_mps: float, manoeuvre: str) -> tuple[list[Json], float]:
    """What the car does from when it disappears on, and how far it gets in that time [m]."""
    straight: Json = {"kind": "straight", "speed_mps": speed_mps}
    if manoeuvre == "keeps speed":
        return [straight], speed_mps * occlusion_s
    if manoeuvre == "brakes":
        braking_s = min(occlusion_s, 0.5 * speed_mps / BRAKING_MPS2)
        slow_mps = speed_mps - BRAKING_MPS2 * braking_s
        way_m = 0.5 * (speed_mps + slow_mps) * braking_s + slow_mps * (occlusion_s - braking_s)
        brake = {**straight, "acceleration_mps2": -BRAKING_MPS2, "duration_s": braking_s}
        return [brake, {**straight, "speed_mps": slow_mps}], way_m
    if manoeuvre == "changes lane":
        # The quintic y = d (10 s^3 - 15 s^4 + 6 s^5) has its largest acceleration, 10 / sqrt(3) d / T^2, at s = 0.21.
        offset_m = min(LANE_M, SIDEWAYS_MPS2 * occlusion_s**2 * math.sqrt(3.0) / 10.0)
        change = {"kind": "lane-change", "speed_mps": speed_mps, "offset_m": offset_m, "change_s": occlusion_s}
        return [{**change, "duration_s": occlusion_s}, straight], speed_mps * occlusion_s
    raise ValueError(f'manoeuvre = "{manoeuvre}": should be "keeps speed", "brakes" or "changes lane"')


def umbra(wall_m: float) -> tuple[float, float]:
    """From where to where, along the near side of the road, no LIDAR sees anything behind a wall of this length [m]."""
    rig = load_rig(RIG, Path())
    x, y = np.array([(mount.x_m + rig.rear_axle_x_m, mount.y_m) for mount in rig.mounts]).T
    reach = (ROAD_Y_M - 0.5 * CAR_M[1] - y) / (WALL_Y_M - y)
    return float(np.max(x + (-0.5 * wall_m - x) * reach)), float(np.min(x + (0.5 * wall_m - x) * reach))


def _wall_length(hidden_m: float) -> float:
    """Length of the wall that hides so much of the road [m]."""
    return float(brentq(lambda wall_m: np.diff(umbra(wall_m)).item() - hidden_m, 0.0, 2.0 * hidden_m + 20.0))


def partly_hidden(hidden_share: float, range_m: float = 15.0, aspect_deg: float = 30.0) -> Json:
    """A car stands before the standing ego, and a wall hides a share of the angle under which it is seen.

    Parameters
    ----------
    hidden_share
        Of the angle between its outermost corners, from the left, 0 to 1.
    range_m
        From the ego's centre to the car's [m].
    aspect_deg
        How the car is turned against the line of sight: 0 shows its rear alone, 90 its side [deg].

    Raises
    ------
    ValueError
        The share is not from 0 to 1.
    """
    if not 0.0 <= hidden_share <= 1.0:
        raise ValueError(f"hidden_share = {hidden_share:g} must be from 0 to 1")
    turn = math.radians(aspect_deg)
    half = 0.5 * np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]]) * CAR_M[:2]
    corners = half @ np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]]) + (range_m, 0.0)
    bearing = np.arctan2(corners[:, 1], corners[:, 0])
    left, right = float(bearing.max()), float(bearing.min())
    end = left - hidden_share * (left - right)
    near_m = 0.6 * (range_m - 0.5 * CAR_M[0])
    wall = [[near_m, near_m * math.tan(left) + 2.0], [near_m, near_m * math.tan(end)]]
    return {
        "description": f"A standing car, {range_m:g} m away, of which a wall hides {hidden_share:.0%}.",
        "duration_s": 2.0,
        "traffic": {
            "kind": "scripted",
            "actor": [{"name": "car", "x_m": range_m, "y_m": 0.0, "yaw_deg": aspect_deg, "size_m": CAR_M}],
            "obstacle": [_wall(wall)] if hidden_share else [],
        },
    }


def _wall(corners_m: list[list[float]]) -> Json:
    return {"kind": "wall", "corners_m": corners_m, "height_m": WALL_HEIGHT_M}
