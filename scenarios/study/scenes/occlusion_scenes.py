"""Scenes that are staged to a measure: functions that make a scenario, as a file holds it, of a few numbers.

A study names one as `scenarios.study.staged:hidden_behind_wall` and varies its parameters by their names. Any function
of a team's own will do as well: parameters in, document out, ValueError for what cannot be staged.
"""

import math
from pathlib import Path
from typing import Any, Literal

import numpy as np

from scenarios.arrays import Floats
from scenarios.study.scenes.scene_parts import CAR_M, car, motion_table, screen, wall
from scenarios.study.scenes.shadow import cover, outline, shadow
from sensor_model.rig.rig import load_rig
from sim.scripted.motions import LaneChange, Motion, Straight, state_at

Json = dict[str, Any]
Manoeuvre = Literal["keeps speed", "brakes", "changes lane"]

RIG = "srx_six_lux"
START = np.array([-6.0, 9.0, 0.0])
"""Of a car that drives two lanes to the left of the ego, 11 m away and a little behind: it shows its front and side."""
WALL_Y_M = 4.0
BEFORE_S, AFTER_S = 3.0, 3.5
"""[s] The car is out in the open: time enough for a track to settle, and to be found again."""
REMEMBERED_S = 4.5
"""[s] Grading follows up longer occlusions than its default of 3 s: hidden in part adds to hidden."""
LANE_M = 3.5
BRAKING_MPS2, SIDEWAYS_MPS2 = 2.0, 2.0
"""[m/s^2] Comfortable, so that nobody in sight would have been warned."""
DRIVING_JITTER = {"jitter_m": 0.25}
"""Two drives are never the same: where the car is when a frame is taken."""
STANDING_JITTER = {"jitter_m": 0.1, "jitter_deg": 2.0}
"""Likewise, with the beams in other places on the car."""
SLIDE_MPS = 5.0
"""[m/s] How fast a screen comes and goes, as the ego sees it."""


def hidden_behind_wall(occlusion_s: float, speed_mps: float, manoeuvre: Manoeuvre = "keeps speed") -> Json:
    """A car drives beside the ego, both equally fast, until a wall hides it; what it does there is not seen.

    The wall is as long as the shadow that the car throws on it meanwhile, in the light of all LIDARS that look there:
    none of them can see any of the car for `occlusion_s`, and no longer.

    Parameters
    ----------
    occlusion_s
        How long nothing of the car can be seen [s].
    speed_mps
        Of the ego, and of the car until it disappears [m/s].
    manoeuvre
        The car keeps its speed; brakes with 2 m/s^2, down to half its speed at most; or changes to the lane farther
        off, as far as 2 m/s^2 sideways take it in that time.

    Raises
    ------
    ValueError
        There is no such manoeuvre, or a number is not positive.
    """
    if not (occlusion_s > 0 and speed_mps > 0):
        raise ValueError(f"occlusion_s = {occlusion_s:g} and speed_mps = {speed_mps:g} must be positive")
    rig, hidden = load_rig(RIG, Path()), _hidden_motions(occlusion_s, speed_mps, manoeuvre)
    vanishes = START + np.array([speed_mps * BEFORE_S, 0.0, 0.0])
    reaches = []
    for time in np.linspace(0.0, occlusion_s, 51):
        ego = np.array([speed_mps * (BEFORE_S + time), 0.0])
        points = outline(state_at(hidden, vanishes, time).pose, CAR_M)
        reaches.append(ego[0] + shadow(rig, points - ego, WALL_Y_M))
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
            "obstacle": [wall([[left_m, WALL_Y_M], [right_m, WALL_Y_M]])],
        },
        "grading": {"memory_s": REMEMBERED_S},
    }


def partly_hidden(visible_share: float, occlusion_s: float = 2.0, speed_mps: float = 10.0) -> Json:
    """A car drives beside the ego, both equally fast; a screen slides between, stays for a while, and slides back.

    Parameters
    ----------
    visible_share
        Of the angle under which the LIDARS see the car, the front part, that stays visible, 0 to 1.
    occlusion_s
        How long the screen stays [s]; it takes about a second each to come and to go.
    speed_mps
        Of both [m/s].

    Raises
    ------
    ValueError
        The share is not from 0 to 1, the time not positive, or both are too slow for a screen to fall back.
    """
    if not (0.0 <= visible_share <= 1.0 and occlusion_s > 0 and speed_mps > SLIDE_MPS):
        raise ValueError(
            f"visible_share = {visible_share:g} must be from 0 to 1, occlusion_s = {occlusion_s:g} positive, "
            f"speed_mps = {speed_mps:g} above {SLIDE_MPS:g}"
        )
    rig, points = load_rig(RIG, Path()), outline(START, CAR_M)
    left_m, right_m = shadow(rig, points, WALL_Y_M)
    length_m = right_m - left_m + 1.0
    away_m = left_m - 0.5  # where the screen ends before and after
    slide_s = (cover(rig, points, WALL_Y_M, 1.0 - visible_share) - away_m) / SLIDE_MPS
    slides = [
        Straight("straight", speed_mps, duration_s=BEFORE_S),
        Straight("straight", speed_mps + SLIDE_MPS, duration_s=slide_s),
        Straight("straight", speed_mps, duration_s=occlusion_s),
        Straight("straight", speed_mps - SLIDE_MPS, duration_s=slide_s),
        Straight("straight", speed_mps),
    ]
    start = np.array([away_m - 0.5 * length_m, WALL_Y_M, 0.0])
    together = Straight("straight", speed_mps)
    return {
        "description": f"A car, of which a screen leaves {visible_share:.0%} visible for {occlusion_s:g} s.",
        "duration_s": BEFORE_S + 2.0 * slide_s + occlusion_s + AFTER_S,
        "traffic": {
            "kind": "scripted",
            "ego": {"motion": [motion_table(together)]},
            "actor": [
                car(START, [together]),
                screen(start, length_m, slides),
            ],
        },
        "grading": {"memory_s": REMEMBERED_S},
    }


def standing_car(range_m: float = 15.0, aspect_deg: float = 30.0, visible_share: float = 1.0) -> Json:
    """A car stands before the standing ego, and a wall may hide a share of the angle under which it is seen.

    Parameters
    ----------
    range_m
        From the ego's centre to the car's [m].
    aspect_deg
        How the car is turned against the line of sight: 0 shows its rear alone, 90 its side [deg].
    visible_share
        Of the angle between its outermost corners, seen from between the front LIDARs; the right part, 0 to 1.

    Raises
    ------
    ValueError
        The share is not from 0 to 1, or the car is so near that no wall fits between.
    """
    if not 0.0 <= visible_share <= 1.0:
        raise ValueError(f"visible_share = {visible_share:g} must be from 0 to 1")
    if range_m < 8.0:
        raise ValueError(f"range_m = {range_m:g} must be 8 or more, so that a wall fits between the ego and the car")
    pose = np.array([range_m, 0.0, math.radians(aspect_deg)])
    return {
        "description": f"A standing car, {range_m:g} m away and turned by {aspect_deg:g} degrees, of which "
        f"{visible_share:.0%} can be seen.",
        "duration_s": 2.0,
        "traffic": {
            "kind": "scripted",
            **STANDING_JITTER,
            "actor": [car(pose, [])],
            "obstacle": [wall(_standing_wall(pose, 1.0 - visible_share))] if visible_share < 1.0 else [],
        },
    }


def _hidden_motions(occlusion_s: float, speed_mps: float, manoeuvre: str) -> list[Motion]:
    """What the car does from when it disappears on."""
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


def _standing_wall(pose: Floats, hidden_share: float) -> list[list[float]]:
    """Ends of a wall across the line of sight that hides the left part of a car at a pose (3,)."""
    rig = load_rig(RIG, Path())
    eye = np.array([max(mount.x_m for mount in rig.mounts) + rig.rear_axle_x_m, 0.0])
    x, y = (outline(pose, CAR_M) - eye).T
    bearing = np.arctan2(y, x)
    end = bearing.max() - hidden_share * np.ptp(bearing)
    away_m = 0.6 * (float(x.min()))  # nearer to the car, both would make one segment
    return [[eye[0] + away_m, away_m * math.tan(bearing.max()) + 2.0], [eye[0] + away_m, away_m * math.tan(end)]]
