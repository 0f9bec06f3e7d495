"""Scene: a wall hides a moving car completely for a given time."""

import math
from typing import Literal

import numpy as np

from luxloop.scenarios.study.scenes.scene_parts import (
    AFTER_S,
    BEFORE_S,
    CAR_M,
    MEMORY_S,
    OCCLUDER_Y_M,
    START,
    Json,
    car,
    motion_table,
    scene_rig,
    wall,
)
from luxloop.scenarios.study.scenes.shadow import outline, shadows_on_line
from luxloop.sim.scripted.motions import LaneChange, Motion, Straight, state_at

Manoeuvre = Literal["keeps speed", "brakes", "changes lane"]

LANE_M = 3.5
BRAKING_MPS2, SIDEWAYS_MPS2 = 2.0, 2.0
"""[m/s^2] Comfortable decelerations and lateral accelerations, as in ordinary traffic."""
DRIVING_JITTER = {"jitter_m": 0.25}
"""Random shift of the start positions by the seed, which varies the phase of the scans."""


def hidden_behind_wall(occlusion_s: float, speed_mps: float, manoeuvre: Manoeuvre = "keeps speed") -> Json:
    """Return a scene in which a wall hides a car that drives beside the ego at the same speed.

    The wall covers exactly the shadow of the car's box on the wall's line during the occlusion, as seen from all LIDARs
    whose field of view contains the box: none of them sees any part of it for `occlusion_s`, and no longer. A bowed car
    is hidden a scan or two longer. A braking one may then leave the side LIDAR's field of view a scan before the rear
    LIDAR sees it past the wall.

    Parameters
    ----------
    occlusion_s
        Time for which the car is completely hidden [s].
    speed_mps
        Speed of the ego, and of the car until it is hidden [m/s].
    manoeuvre
        Motion of the car while it is hidden: it keeps its speed; brakes with 2 m/s^2, down to half its speed at most;
        or changes to the lane farther away, as far as 2 m/s^2 of lateral acceleration allow in that time.

    Raises
    ------
    ValueError
        The manoeuvre is unknown, or a number is not positive.
    """
    if not (occlusion_s > 0 and speed_mps > 0):
        raise ValueError(f"occlusion_s = {occlusion_s:g} and speed_mps = {speed_mps:g} must be positive")
    rig, hidden = scene_rig(), _hidden_motions(occlusion_s, speed_mps, manoeuvre)
    vanishes = START + np.array([speed_mps * BEFORE_S, 0.0, 0.0])
    times_s = np.linspace(0.0, occlusion_s, 51)
    ego_x_m = speed_mps * (BEFORE_S + times_s)
    points = np.stack([outline(state_at(hidden, vanishes, time).pose, CAR_M) for time in times_s])
    points[..., 0] -= ego_x_m[:, None]
    reaches = ego_x_m[:, None] + shadows_on_line(rig, points, OCCLUDER_Y_M)
    left_m, right_m = float(np.min(reaches)), float(np.max(reaches))
    motions = [Straight("straight", speed_mps, duration_s=BEFORE_S), *hidden]
    return {
        "description": f"A car at {speed_mps:g} m/s {manoeuvre} while a wall hides it for {occlusion_s:g} s.",
        "duration_s": BEFORE_S + occlusion_s + AFTER_S,
        "traffic": {
            "kind": "scripted",
            **DRIVING_JITTER,
            "ego": {"motion": [motion_table(Straight("straight", speed_mps))]},
            "actor": [car(START, motions)],
            "obstacle": [wall([[left_m, OCCLUDER_Y_M], [right_m, OCCLUDER_Y_M]])],
        },
        "grading": {"memory_s": MEMORY_S},
    }


def _hidden_motions(occlusion_s: float, speed_mps: float, manoeuvre: str) -> list[Motion]:
    """Return the motions of the car from the time it is hidden."""
    if manoeuvre == "keeps speed":
        return [Straight("straight", speed_mps)]
    if manoeuvre == "brakes":
        braking_s = min(occlusion_s, 0.5 * speed_mps / BRAKING_MPS2)
        slow_mps = speed_mps - BRAKING_MPS2 * braking_s
        return [Straight("straight", speed_mps, -BRAKING_MPS2, braking_s), Straight("straight", slow_mps)]
    if manoeuvre == "changes lane":
        # The quintic y = d (10 s^3 - 15 s^4 + 6 s^5) has its largest acceleration, 10 / sqrt(3) d / T^2, at s = 0.21.
        offset_m = min(LANE_M, SIDEWAYS_MPS2 * occlusion_s**2 * math.sqrt(3.0) / 10.0)
        return [LaneChange("lane-change", speed_mps, offset_m, occlusion_s)]
    raise ValueError(f'manoeuvre = "{manoeuvre}": should be "keeps speed", "brakes" or "changes lane"')
