"""Encounters: a road user appears from behind a parked truck, a turning bus, a lorry or a house.

The ego drives along the x axis. After `APPROACH_S` its front is at the meeting point of both paths, and the actor is
there, too. The run ends directly afterwards, so an actor that is confirmed too late is never confirmed.
"""

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np
import scipy

from luxloop.arrays import Floats
from luxloop.scenarios.study.scenes.scene_parts import CAR_M, Json, Size, motion_table, road_user, wall
from luxloop.sim.scripted.motions import Arc, LaneChange, Motion, Straight
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


TRUCK_M: Size = (8.0, 2.5, 3.2)
TRUCK_Y_M = -3.2
"""[m] Lateral position of the truck: 1 m of free space to the ego's side."""
TRUCK_WALL_Y_M = -5.5
"""[m] Lateral position of a wall behind the truck, with an opening where the target comes from."""
CHILD_M: Size = (0.25, 0.35, 1.2)
"""[m] Depth, width and height of a child of seven years."""
TRUCK_GAP_M = 1.0
"""[m] Free space between the front of the truck and the side of the target."""
CROSSING_TARGETS = {"car": ("car", TARGET_M), "child": ("pedestrian", CHILD_M)}
"""Kind and size of each target."""


def behind_parked_truck(ego_mps: float, target_mps: float, who: Literal["car", "child"] = "car") -> Json:
    """Return a scene in which a target crosses from the right, 1 m in front of a parked truck that hides it.

    Ego and target keep their speeds and would collide.

    Parameters
    ----------
    ego_mps, target_mps
        Speeds of the ego and of the target [m/s].
    who
        The target: a car that leaves a driveway, or a child.

    Raises
    ------
    ValueError
        A speed is not positive, or the target is unknown.
    """
    require_speeds(ego_mps, target_mps)
    if who not in CROSSING_TARGETS:
        raise ValueError(f'who = "{who}": should be "car" or "child"')
    kind, size_m = CROSSING_TARGETS[who]
    start = crossing_start(front_after_approach(ego_mps), size_m, target_mps)
    opening_m = float(start[0]) - 0.5 * size_m[1] - TRUCK_GAP_M
    truck = np.array([opening_m - 0.5 * TRUCK_M[0], TRUCK_Y_M, 0.0])
    actors = [
        road_user(TARGET, kind, start, size_m, straight(target_mps)),
        road_user("truck", "truck", truck, TRUCK_M),
    ]
    before = wall([[-20.0, TRUCK_WALL_Y_M], [opening_m, TRUCK_WALL_Y_M]])
    description = f"A {who} at {target_mps:g} m/s crosses before a parked truck, the ego drives at {ego_mps:g} m/s."
    return encounter(description, actors, [before], straight(ego_mps))


BUS_M: Size = (12.0, 2.5, 3.4)
BUS_RADIUS_M = 12.0
"""[m] Radius of the ego's turn."""
BUS_BEFORE_S = 2.0
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
    turn_s, meeting = _bus_meeting(ego_mps)
    approach_s = BUS_BEFORE_S + turn_s
    turn_at_m = ego_mps * BUS_BEFORE_S
    # The car's front then touches the side of the strip of road that the ego's front has reached.
    front_m = turn_at_m + meeting[0] + 0.5 * EGO_SIZE[1] + target_mps * approach_s
    start = np.array([front_m + 0.5 * TARGET_M[0], 2.0 * LANE_M, math.pi])
    bus = np.array([turn_at_m + BUS_FRONT_M + 0.5 * BUS_M[0], LANE_M, math.pi])
    actors = [
        road_user(TARGET, "car", start, TARGET_M, straight(target_mps)),
        road_user("bus", "bus", bus, BUS_M),
    ]
    ego: list[Motion] = [Straight("straight", ego_mps, duration_s=BUS_BEFORE_S), Arc("arc", ego_mps, BUS_RADIUS_M)]
    description = f"An oncoming car at {target_mps:g} m/s behind a bus, while the ego turns left at {ego_mps:g} m/s."
    return encounter(description, actors, [], ego, approach_s)


def _bus_meeting(ego_mps: float) -> tuple[float, tuple[float, float]]:
    """Return the time from the begin of the turn until the ego's front is at the meeting point [s], and this point.

    In a turn by the angle a, the front is at y = R (1 - cos a) + L / 2 sin a = R - A cos(a + p), with the amplitude
    A = hypot(R, L / 2) and the phase p = atan2(L / 2, R).
    """
    y_m, half_m = 2.0 * LANE_M - half_widths(TARGET_M), 0.5 * EGO_SIZE[0]
    angle = math.acos((BUS_RADIUS_M - y_m) / math.hypot(BUS_RADIUS_M, half_m)) - math.atan2(half_m, BUS_RADIUS_M)
    return angle * BUS_RADIUS_M / ego_mps, (BUS_RADIUS_M * math.sin(angle) + half_m * math.cos(angle), y_m)


LORRY_M: Size = (16.5, 2.55, 4.0)
OCCLUDERS = {"lorry": "trailer-truck", "coach": "bus"}
"""Kind of each occluder."""
LORRY_GAP_M = 3.0
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
    lorry = start + np.array([-0.5 * (TARGET_M[0] + LORRY_M[0]) - LORRY_GAP_M, LANE_M, 0.0])
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


HOUSE_SIDE_M = 2.5
"""[m] From the centre of the target's lane to the wall of the house."""
PAVEMENT_M = 2.5
"""[m] From the edge of the ego's lane to the front of the house."""
HOUSE_M = (20.0, 40.0)
"""[m] Length of the house along the ego's street, and along the side street."""


def past_house(ego_mps: float, target_mps: float) -> Json:
    """Return a scene in which a car crosses from the right out of a side street, hidden by the house at the corner.

    Ego and car keep their speeds and would collide.

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
    start = crossing_start(front_after_approach(ego_mps), TARGET_M, target_mps)
    right_m, front_m = float(start[0]) - HOUSE_SIDE_M, -1.75 - PAVEMENT_M
    left_m, back_m = right_m - HOUSE_M[0], front_m - HOUSE_M[1]
    corners = [[left_m, front_m], [left_m, back_m], [right_m, back_m], [right_m, front_m]]
    description = f"A car at {target_mps:g} m/s leaves a side street past a house, the ego drives at {ego_mps:g} m/s."
    target = road_user(TARGET, "car", start, TARGET_M, straight(target_mps))
    return encounter(description, [target], [{"kind": "building", "corners_m": corners}], straight(ego_mps))
