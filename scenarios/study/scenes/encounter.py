"""Encounters: scenes in which an actor emerges from an occlusion on a collision course with the ego.

The ego drives along the x axis. After `APPROACH_S` its front is at the meeting point of both paths, and the actor is
there, too. The run ends directly afterwards, so an actor that is confirmed too late is never confirmed.
"""

from collections.abc import Sequence

import numpy as np

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.study.scenes.scene_parts import CAR_M, Json, Size, motion_table
from luxloop.sim.scripted.motions import Motion, Straight
from luxloop.sim.scripted.script import EGO_SIZE

APPROACH_S = 4.0
"""[s] From the start of the run until the ego's front is at the meeting point."""
END_S = 0.24
"""[s] From then until the end of the run: three scans, so that the run contains the meeting point also with jitter."""
LANE_M = 3.5
"""[m] Width of a lane."""
JITTER = {"jitter_m": 0.25}
"""Random shift of all actors by the seed, which varies the scan in which the target emerges."""
TARGET = "target"
"""Name of the emerging actor."""
TARGET_M = CAR_M
"""[m] Size of an emerging car."""


def require_speeds(ego_mps: float, target_mps: float) -> None:
    """Raise a ValueError unless both speeds are positive."""
    if not (ego_mps > 0 and target_mps > 0):
        raise ValueError(f"ego_mps = {ego_mps:g} and target_mps = {target_mps:g} must be positive")


def half_widths(size_m: Size) -> float:
    """Return the distance of the paths at the meeting point: half the sum of the widths of ego and target [m]."""
    return 0.5 * (EGO_SIZE[1] + size_m[1])


def crossing_start(meeting_x_m: float, size_m: Size, target_mps: float) -> Floats:
    """Return the start pose (3,) of a target that crosses the ego's lane from the right.

    When the ego's front is at `meeting_x_m`, the target's front touches the strip of road that the ego covers.
    """
    front_m = -0.5 * EGO_SIZE[1] - target_mps * APPROACH_S
    return np.array([meeting_x_m + half_widths(size_m), front_m - 0.5 * size_m[0], 0.5 * np.pi])


def front_after_approach(ego_mps: float) -> float:
    """Return x of the front of an ego that drives straight, at the end of the approach [m]."""
    return 0.5 * EGO_SIZE[0] + ego_mps * APPROACH_S


def encounter(
    description: str,
    actors: list[Json],
    obstacles: Sequence[Json],
    ego: Sequence[Motion],
    approach_s: float = APPROACH_S,
) -> Json:
    """Return the scenario of an encounter, with the target named `TARGET` among its actors."""
    return {
        "description": description,
        "duration_s": approach_s + END_S,
        "traffic": {
            "kind": "scripted",
            **JITTER,
            "ego": {"motion": [motion_table(motion) for motion in ego]},
            "actor": actors,
            "obstacle": list(obstacles),
        },
        "grading": {"target": TARGET},
    }


def straight(speed_mps: float) -> list[Motion]:
    """Return the motion of a road user that keeps course and speed."""
    return [Straight("straight", speed_mps)]
