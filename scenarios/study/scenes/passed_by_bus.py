"""Scene: a bus that overtakes the ego hides a car in the lane beyond it."""

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
    road_user,
    scene_rig,
)
from luxloop.scenarios.study.scenes.shadow import outline, shadow_on_line
from luxloop.sim.scripted.motions import Straight

WIDTH_M, HEIGHT_M = 2.5, 3.2
LENGTH_M = (6.0, 18.75)
"""[m] Shortest and longest bus: a minibus, and the legal maximum in the EU."""
JITTER = {"jitter_m": 0.1}
"""Random shift of the start positions by the seed, which varies the phase of the scans."""


def passed_by_bus(occlusion_s: float, speed_mps: float = 10.0, closing_mps: float = 5.0) -> Json:
    """Return a scene in which a bus passes between the ego and a car, which both drive at the same speed.

    Every ray from a LIDAR to the car's box meets the bus while its front is ahead of the foremost and its rear behind
    the rearmost of them. The length of the bus follows from the time hidden and its speed relative to the ego.

    Parameters
    ----------
    occlusion_s
        Time for which the car is completely hidden [s].
    speed_mps
        Speed of the ego and of the car [m/s].
    closing_mps
        Speed of the bus relative to them [m/s].

    Raises
    ------
    ValueError
        A time or speed is not positive, or the bus would be too short or too long.
    """
    if not (occlusion_s > 0 and speed_mps > 0 and closing_mps > 0):
        raise ValueError(
            f"occlusion_s = {occlusion_s:g}, speed_mps = {speed_mps:g} and closing_mps = {closing_mps:g} "
            "must be positive"
        )
    foremost_m, rearmost_m = _ends()
    length_m = occlusion_s * closing_mps + foremost_m - rearmost_m
    if not LENGTH_M[0] <= length_m <= LENGTH_M[1]:
        raise ValueError(
            f"occlusion_s = {occlusion_s:g} with closing_mps = {closing_mps:g} needs a bus of {length_m:.1f} m; "
            f"choose values for {LENGTH_M[0]:g} to {LENGTH_M[1]:g} m"
        )
    front_m = foremost_m - closing_mps * BEFORE_S
    start = np.array([front_m - 0.5 * length_m, OCCLUDER_Y_M, 0.0])
    passing = Straight("straight", speed_mps + closing_mps)
    return {
        "description": f"A bus passes at {closing_mps:g} m/s and hides a car beyond it for {occlusion_s:g} s.",
        "duration_s": BEFORE_S + occlusion_s + AFTER_S,
        "traffic": {
            "kind": "scripted",
            **JITTER,
            "ego": {"motion": [motion_table(Straight("straight", speed_mps))]},
            "actor": [
                car(START, [Straight("straight", speed_mps)]),
                road_user("bus", "bus", start, (length_m, WIDTH_M, HEIGHT_M), [passing]),
            ],
        },
        "grading": {"memory_s": MEMORY_S},
    }


def _ends() -> tuple[float, float]:
    """Return the x [m] that the front of the bus must have passed, and the x that its rear must not have reached.

    A ray is blocked if it meets the bus anywhere between its two sides, so the side that needs least counts for each.
    """
    rig, points = scene_rig(), outline(START, CAR_M)
    sides = [shadow_on_line(rig, points, OCCLUDER_Y_M + side * 0.5 * WIDTH_M) for side in (-1.0, 1.0)]
    return min(right for _, right in sides), max(left for left, _ in sides)
