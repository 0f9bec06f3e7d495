"""Scene: the ego turns left, and a bus that waits to turn left hides an oncoming car."""

import math

import numpy as np

from luxloop.scenarios.study.scenes.encounter import (
    LANE_M,
    TARGET,
    TARGET_M,
    encounter,
    half_widths,
    require_speeds,
    straight,
)
from luxloop.scenarios.study.scenes.scene_parts import Json, Size, road_user
from luxloop.sim.scripted.motions import Arc, Motion, Straight
from luxloop.sim.scripted.script import EGO_SIZE

BUS_M: Size = (12.0, 2.5, 3.4)
RADIUS_M = 12.0
"""[m] Radius of the ego's turn."""
BEFORE_S = 2.0
"""[s] Time that the ego drives straight before it turns."""
BUS_FRONT_M = 7.0
"""[m] From the beginning of the ego's turn to the front of the bus."""


def behind_turning_bus(ego_mps: float, target_mps: float) -> Json:
    """Return a scene in which the ego turns left across the lane of an oncoming car, hidden by a bus.

    The bus stands in the lane beside the ego's and waits to turn left, too. The car passes it on its other side. Both
    keep their speeds and would collide.

    Parameters
    ----------
    ego_mps, target_mps
        Speeds of the ego and of the car [m/s].

    Raises
    ------
    ValueError
        A speed is not positive.
    """
    require_speeds(ego_mps, target_mps)
    turn_s, meeting = _meeting(ego_mps)
    approach_s = BEFORE_S + turn_s
    turn_at_m = ego_mps * BEFORE_S
    # The car's front then touches the side of the strip of road that the ego's front has reached.
    front_m = turn_at_m + meeting[0] + 0.5 * EGO_SIZE[1] + target_mps * approach_s
    start = np.array([front_m + 0.5 * TARGET_M[0], 2.0 * LANE_M, math.pi])
    bus = np.array([turn_at_m + BUS_FRONT_M + 0.5 * BUS_M[0], LANE_M, math.pi])
    actors = [
        road_user(TARGET, "car", start, TARGET_M, straight(target_mps)),
        road_user("bus", "bus", bus, BUS_M),
    ]
    ego: list[Motion] = [Straight("straight", ego_mps, duration_s=BEFORE_S), Arc("arc", ego_mps, RADIUS_M)]
    description = f"An oncoming car at {target_mps:g} m/s behind a bus, while the ego turns left at {ego_mps:g} m/s."
    return encounter(description, actors, [], ego, approach_s)


def _meeting(ego_mps: float) -> tuple[float, tuple[float, float]]:
    """Return the time from the begin of the turn until the ego's front is at the meeting point [s], and this point.

    In a turn by the angle a, the front is at y = R (1 - cos a) + L / 2 sin a = R - A cos(a + p), with the amplitude
    A = hypot(R, L / 2) and the phase p = atan2(L / 2, R).
    """
    y_m, half_m = 2.0 * LANE_M - half_widths(TARGET_M), 0.5 * EGO_SIZE[0]
    angle = math.acos((RADIUS_M - y_m) / math.hypot(RADIUS_M, half_m)) - math.atan2(half_m, RADIUS_M)
    return angle * RADIUS_M / ego_mps, (RADIUS_M * math.sin(angle) + half_m * math.cos(angle), y_m)
