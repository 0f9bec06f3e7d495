"""Agreement of the directions of neighbours with a heading, see `luxloop.tracker.tracking.traffic_flow`."""

import math

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.compiled import kernel


@kernel()
def axis_agreement(
    position: Floats,
    direction: Floats,
    ids: Ints,
    without_id: int,
    place: Floats,
    heading: float,
    range_m: float,
) -> tuple[float, float]:
    """Return the sum of the weights of K neighbours, and that of their weighted agreements with an axis.

    Neighbours at (K, 2) [m] have directions (K,), `ids` (K,) of which one does not count, and weights that decrease
    with the distance from the place (2,).
    """
    total, agreement = 0.0, 0.0
    for k in range(len(direction)):
        if ids[k] == without_id:
            continue
        weight = math.exp(-math.hypot(position[k, 0] - place[0], position[k, 1] - place[1]) / range_m)
        total += weight
        agreement += weight * math.cos(2.0 * (direction[k] - heading))
    return total, agreement


@kernel()
def front_agreement(
    position: Floats,
    direction: Floats,
    ids: Ints,
    without_id: int,
    place: Floats,
    heading: float,
    range_m: float,
    lane_m: float,
) -> tuple[float, float]:
    """Return the sum of the weights of K neighbours, and that of their weighted agreements with a front.

    Neighbours at (K, 2) [m] have directions (K,), `ids` (K,) of which one does not count, and weights that decrease
    along the heading with the distance from the place (2,), and across it within a lane.
    """
    total, agreement = 0.0, 0.0
    cos, sin = math.cos(heading), math.sin(heading)
    for k in range(len(direction)):
        if ids[k] == without_id:
            continue
        x, y = position[k, 0] - place[0], position[k, 1] - place[1]
        along, across = cos * x + sin * y, cos * y - sin * x
        weight = math.exp(-abs(along) / range_m - 0.5 * (across / lane_m) ** 2)
        total += weight
        agreement += weight * math.cos(direction[k] - heading)
    return total, agreement
