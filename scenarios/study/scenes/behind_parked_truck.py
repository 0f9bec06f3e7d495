"""Scene: a car or a child crosses the ego's lane from behind a parked truck."""

from typing import Literal

import numpy as np

from luxloop.scenarios.study.scenes.encounter import (
    TARGET,
    TARGET_M,
    crossing_start,
    encounter,
    front_after_approach,
    require_speeds,
    straight,
)
from luxloop.scenarios.study.scenes.scene_parts import Json, Size, road_user, wall

TRUCK_M: Size = (8.0, 2.5, 3.2)
TRUCK_Y_M = -3.2
"""[m] Lateral position of the truck: 1 m of free space to the ego's side."""
WALL_Y_M = -5.5
"""[m] Lateral position of a wall behind the truck, with an opening where the target comes from."""
CHILD_M: Size = (0.25, 0.35, 1.2)
"""[m] Depth, width and height of a child of seven years."""
GAP_M = 1.0
"""[m] Free space between the front of the truck and the side of the target."""
TARGETS = {"car": ("car", TARGET_M), "child": ("pedestrian", CHILD_M)}
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
    if who not in TARGETS:
        raise ValueError(f'who = "{who}": should be "car" or "child"')
    kind, size_m = TARGETS[who]
    start = crossing_start(front_after_approach(ego_mps), size_m, target_mps)
    opening_m = float(start[0]) - 0.5 * size_m[1] - GAP_M
    truck = np.array([opening_m - 0.5 * TRUCK_M[0], TRUCK_Y_M, 0.0])
    actors = [
        road_user(TARGET, kind, start, size_m, straight(target_mps)),
        road_user("truck", "truck", truck, TRUCK_M),
    ]
    before = wall([[-20.0, WALL_Y_M], [opening_m, WALL_Y_M]])
    description = f"A {who} at {target_mps:g} m/s crosses before a parked truck, the ego drives at {ego_mps:g} m/s."
    return encounter(description, actors, [before], straight(ego_mps))
