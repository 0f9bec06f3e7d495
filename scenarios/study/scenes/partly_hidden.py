"""Cars of which a given part is visible: behind a moving screen, passed by a bus, or standing alone."""

import math

import numpy as np

from luxloop.arrays import Floats
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
    outline,
    road_user,
    scene_rig,
    screen,
    screen_end,
    shadow_on_line,
    wall,
)
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


STANDING_JITTER = {"jitter_m": 0.1, "jitter_deg": 2.0}
"""Random shift and rotation of the car by the seed, which varies the beams that hit it."""


def standing_car(range_m: float = 15.0, aspect_deg: float = 30.0, visible_share: float = 1.0) -> Json:
    """Return a scene with a stationary car in front of the stationary ego; a wall may hide a share of the car.

    Parameters
    ----------
    range_m
        Distance from the ego's centre to the car's centre [m].
    aspect_deg
        Angle of the car's heading to the line of sight: 0 shows the rear only, 90 the side [deg].
    visible_share
        Visible share of the angle between the outermost corners, seen from between the front LIDARs; the right part,
        0 to 1.

    Raises
    ------
    ValueError
        The share is not from 0 to 1, or the car is too close for a wall in between.
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
            "obstacle": [wall(_wall_corners(pose, 1.0 - visible_share))] if visible_share < 1.0 else [],
        },
    }


def _wall_corners(pose: Floats, hidden_share: float) -> list[list[float]]:
    """Return the ends of a wall across the line of sight that hides the left part of a car at a pose (3,)."""
    rig = scene_rig()
    viewpoint = np.array([max(mount.x_m for mount in rig.mounts) + rig.rear_axle_x_m, 0.0])
    x, y = (outline(pose, CAR_M) - viewpoint).T
    bearing = np.arctan2(y, x)
    end = bearing.max() - hidden_share * np.ptp(bearing)
    away_m = 0.6 * (float(x.min()))  # a wall closer to the car would be in the same segment
    return [
        [viewpoint[0] + away_m, away_m * math.tan(bearing.max()) + 2.0],
        [viewpoint[0] + away_m, away_m * math.tan(end)],
    ]
