"""Scene: a car drives out of a side street past the corner of a house."""

from luxloop.scenarios.study.scenes.encounter import (
    TARGET,
    TARGET_M,
    crossing_start,
    encounter,
    front_after_approach,
    require_speeds,
    straight,
)
from luxloop.scenarios.study.scenes.scene_parts import Json, road_user

SIDE_M = 2.5
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
    right_m, front_m = float(start[0]) - SIDE_M, -1.75 - PAVEMENT_M
    left_m, back_m = right_m - HOUSE_M[0], front_m - HOUSE_M[1]
    corners = [[left_m, front_m], [left_m, back_m], [right_m, back_m], [right_m, front_m]]
    description = f"A car at {target_mps:g} m/s leaves a side street past a house, the ego drives at {ego_mps:g} m/s."
    target = road_user(TARGET, "car", start, TARGET_M, straight(target_mps))
    return encounter(description, [target], [{"kind": "building", "corners_m": corners}], straight(ego_mps))
