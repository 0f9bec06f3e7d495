"""Scene: a stationary car, which a wall may partly hide."""

import math

import numpy as np

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.study.scenes.scene_parts import CAR_M, Json, car, scene_rig, wall
from luxloop.scenarios.study.scenes.shadow import outline

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
