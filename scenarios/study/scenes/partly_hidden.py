"""Scene: a moving screen hides a given share of a moving car."""

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
    screen,
)
from luxloop.scenarios.study.scenes.shadow import outline, screen_end, shadow_on_line
from luxloop.sim.scripted.motions import Straight

SLIDE_MPS = 5.0
"""[m/s] Speed of the screen relative to the ego while it arrives and leaves."""


def partly_hidden(visible_share: float, occlusion_s: float = 2.0, speed_mps: float = 10.0) -> Json:
    """Return a scene in which a screen slides between the ego and a car beside it, stays for a while, and slides back.

    Parameters
    ----------
    visible_share
        Share of the car's angular extent, seen from the LIDARs, that stays visible: its front part, 0 to 1.
    occlusion_s
        Time for which the screen stays [s]; it takes about one second each to arrive and to leave.
    speed_mps
        Speed of the ego and of the car [m/s].

    Raises
    ------
    ValueError
        The share is not from 0 to 1, the time is not positive, or the speed is too low for the screen to fall back.
    """
    if not (0.0 <= visible_share <= 1.0 and occlusion_s > 0 and speed_mps > SLIDE_MPS):
        raise ValueError(
            f"visible_share = {visible_share:g} must be from 0 to 1, occlusion_s = {occlusion_s:g} positive, "
            f"speed_mps = {speed_mps:g} above {SLIDE_MPS:g}"
        )
    rig, points = scene_rig(), outline(START, CAR_M)
    left_m, right_m = shadow_on_line(rig, points, OCCLUDER_Y_M)
    length_m = right_m - left_m + 1.0
    away_m = left_m - 0.5  # front end of the screen before and after the occlusion
    slide_s = (screen_end(rig, points, OCCLUDER_Y_M, 1.0 - visible_share) - away_m) / SLIDE_MPS
    slides = [
        Straight("straight", speed_mps, duration_s=BEFORE_S),
        Straight("straight", speed_mps + SLIDE_MPS, duration_s=slide_s),
        Straight("straight", speed_mps, duration_s=occlusion_s),
        Straight("straight", speed_mps - SLIDE_MPS, duration_s=slide_s),
        Straight("straight", speed_mps),
    ]
    start = np.array([away_m - 0.5 * length_m, OCCLUDER_Y_M, 0.0])
    constant_speed = Straight("straight", speed_mps)
    return {
        "description": f"A car, of which a screen leaves {visible_share:.0%} visible for {occlusion_s:g} s.",
        "duration_s": BEFORE_S + 2.0 * slide_s + occlusion_s + AFTER_S,
        "traffic": {
            "kind": "scripted",
            "ego": {"motion": [motion_table(constant_speed)]},
            "actor": [
                car(START, [constant_speed]),
                screen(start, length_m, slides),
            ],
        },
        "grading": {"memory_s": MEMORY_S},
    }
