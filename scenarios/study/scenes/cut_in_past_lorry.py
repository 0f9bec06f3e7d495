"""Scene: a car cuts in across the front of a lorry that hid it."""

from typing import Literal

import numpy as np
import scipy

from luxloop.scenarios.study.scenes.encounter import (
    APPROACH_S,
    LANE_M,
    TARGET,
    TARGET_M,
    encounter,
    front_after_approach,
    half_widths,
    require_speeds,
    straight,
)
from luxloop.scenarios.study.scenes.scene_parts import Json, Size, road_user
from luxloop.sim.scripted.motions import LaneChange, Motion, Straight

LORRY_M: Size = (16.5, 2.55, 4.0)
OCCLUDERS = {"lorry": "trailer-truck", "coach": "bus"}
"""Kind of each occluder."""
GAP_M = 3.0
"""[m] From the front of the lorry to the rear of the car."""
CHANGE_S = 4.0
"""[s] Time of the change over two lanes, with 2.5 m/s^2 of lateral acceleration at most."""


def cut_in_past_lorry(ego_mps: float, target_mps: float, occluder: Literal["lorry", "coach"] = "lorry") -> Json:
    """Return a scene in which a car changes from an on-ramp over two lanes into the ego's lane, closely before a lorry.

    The lorry drives in the lane between them, as fast as the car, and hides it from the ego, which is faster. The ego's
    front reaches the rear of the car where the car has come into its lane.

    Parameters
    ----------
    ego_mps, target_mps
        Speeds of the ego, and of car and lorry [m/s].
    occluder
        A lorry, below whose trailer a low LIDAR sees, or a coach in its place, which is closed down to the ground.

    Raises
    ------
    ValueError
        A speed is not positive, the ego is not faster than the car, or the occluder is unknown.
    """
    require_speeds(ego_mps, target_mps)
    if occluder not in OCCLUDERS:
        raise ValueError(f'occluder = "{occluder}": should be "lorry" or "coach"')
    if ego_mps <= target_mps:
        raise ValueError(f"ego_mps = {ego_mps:g}: should be more than target_mps = {target_mps:g}, to catch up")
    meeting_m = front_after_approach(ego_mps)
    entered_s = APPROACH_S - 0.5 * TARGET_M[0] / target_mps  # then the car's centre is at the meeting point
    keeps_s = entered_s - _time_to_enter()
    if keeps_s <= 0:
        raise ValueError(f"target_mps = {target_mps:g}: too slow to change lanes within {APPROACH_S:g} s")
    start = np.array([meeting_m - target_mps * entered_s, -2.0 * LANE_M, 0.0])
    lorry = start + np.array([-0.5 * (TARGET_M[0] + LORRY_M[0]) - GAP_M, LANE_M, 0.0])
    change: list[Motion] = [
        Straight("straight", target_mps, duration_s=keeps_s),
        LaneChange("lane-change", target_mps, 2.0 * LANE_M, CHANGE_S),
    ]
    actors = [
        road_user(TARGET, "car", start, TARGET_M, change),
        road_user(occluder, OCCLUDERS[occluder], lorry, LORRY_M, straight(target_mps)),
    ]
    description = f"A car at {target_mps:g} m/s cuts in past a {occluder}, the ego drives at {ego_mps:g} m/s."
    return encounter(description, actors, [], straight(ego_mps))


def _time_to_enter() -> float:
    """Return the time from the begin of the change until the paths are half the sum of the widths apart [s]."""
    lateral = LaneChange("lane-change", 1.0, 2.0 * LANE_M, CHANGE_S)
    left_m = 2.0 * LANE_M - half_widths(TARGET_M)
    return float(scipy.optimize.brentq(lambda time: lateral.at(time).pose[1] - left_m, 0.0, CHANGE_S))
