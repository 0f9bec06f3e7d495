"""Hot loops of best selection."""

import math

import numpy as np
from numba import njit

from tracker.arrays import Floats, Ints

BINS_PER_REACH = 4
"""Places are counted in bins this much narrower than the kernel, two thirds of its standard deviation."""
TURN_MAX = math.radians(2.0)
"""First step of the refinement; all its steps together turn a heading by twice as much."""
HALVINGS = 7
"""Steps of the refinement: the last is 1/32 of a degree."""


@njit(cache=True)
def side_distances(points: Floats, offset: Ints, heading: Floats) -> Floats:
    """Distance (N, M) of points to the side of a rectangle that their line lies along, moved to the line's median.

    Line g has points offset[g] to offset[g + 1] and candidate headings (G, M). Of a rectangle's two directions it
    lies along the one that its points spread less across.
    """
    distance = np.empty((len(points), heading.shape[1]))
    for g in range(len(offset) - 1):
        x, y = points[offset[g] : offset[g + 1], 0], points[offset[g] : offset[g + 1], 1]
        for m in range(heading.shape[1]):
            cos, sin = math.cos(heading[g, m]), math.sin(heading[g, m])
            along, across = cos * x + sin * y, cos * y - sin * x
            place = across if across.std() <= along.std() else along
            distance[offset[g] : offset[g + 1], m] = np.abs(place - np.median(place))
    return distance


@njit(cache=True)
def company(place: Floats, reach: float, out: Floats) -> None:
    """How many other points are at each point's place, into `out`.

    One at distance d counts (1 - (d / reach)^2)^2, a kernel with a standard deviation of 0.38 reach: it is a density
    estimate that leaves the point itself out. Each place is shared between the two bins around it, and read from the
    two likewise, so that the estimate is continuous and needs no sorting.
    """
    low, pitch = place.min(), reach / BINS_PER_REACH
    count = np.zeros(int((place.max() - low) / pitch) + 2 * BINS_PER_REACH + 2)
    smooth = np.zeros(len(count))
    for i in range(len(place)):
        at = (place[i] - low) / pitch + BINS_PER_REACH
        share = at - int(at)
        count[int(at)] += 1.0 - share
        count[int(at) + 1] += share
    for node in range(BINS_PER_REACH, len(count) - BINS_PER_REACH):
        smooth[node] = count[node]
        for d in range(1, BINS_PER_REACH):
            smooth[node] += (1.0 - (d / BINS_PER_REACH) ** 2) ** 2 * (count[node - d] + count[node + d])
    beside = (1.0 - (1.0 / BINS_PER_REACH) ** 2) ** 2
    for i in range(len(place)):
        at = (place[i] - low) / pitch + BINS_PER_REACH
        share = at - int(at)
        own = (1.0 - share) ** 2 + share**2 + 2.0 * share * (1.0 - share) * beside
        out[i] = (1.0 - share) * smooth[int(at)] + share * smooth[int(at) + 1] - own


@njit(cache=True)
def sharpness(normal_x: float, normal_y: float, ray: Floats, reach: float, flatness: float) -> float:
    """Reach across a side with that normal, seen along the unit vector `ray`: range noise projected on the normal.

    A side seen at a grazing angle is `flatness` sharp, one seen face on blunter by `reach`.
    """
    return math.hypot(reach * (normal_x * ray[0] + normal_y * ray[1]), flatness)


@njit(cache=True)
def misalignment(
    points: Floats, heading: float, ray: Floats, reach: float, flatness: float, along: Floats, across: Floats
) -> float:
    """Cost of a heading: minus the mean over the points of log(1 + company), on a line along it or across it.

    A point is level with others where it lies on a side; of its two companies the denser is taken for its own side:
    they count as a density does, per reach. `along` and `across` are room for one number per point.
    """
    cos, sin = math.cos(heading), math.sin(heading)
    reach_along = sharpness(cos, sin, ray, reach, flatness)
    reach_across = sharpness(-sin, cos, ray, reach, flatness)
    company(cos * points[:, 0] + sin * points[:, 1], reach_along, along)
    company(cos * points[:, 1] - sin * points[:, 0], reach_across, across)
    total = 0.0
    for i in range(len(points)):
        total += math.log(1.0 + reach * max(along[i] / reach_along, across[i] / reach_across))
    return -total / len(points)


@njit(cache=True)
def align(points: Floats, offset: Ints, heading: Floats, reach: float, flatness: float) -> tuple[Floats, Floats]:
    """Turn the cheapest of each segment's headings (S, M) to the cost's least; the sensor is at the origin.

    Returns the headings (S, M + 1), the turned one last, and their costs.
    """
    segments, methods = heading.shape
    turned, cost = np.empty((segments, methods + 1)), np.empty((segments, methods + 1))
    turned[:, :methods] = heading
    for s in range(segments):
        segment = points[offset[s] : offset[s + 1]]
        along, across = np.empty(len(segment)), np.empty(len(segment))
        bearing = math.atan2(segment[:, 1].mean(), segment[:, 0].mean())
        ray = np.array([math.cos(bearing), math.sin(bearing)])
        for m in range(methods):
            cost[s, m] = misalignment(segment, heading[s, m], ray, reach, flatness, along, across)
        cheapest = np.argmin(cost[s, :methods])
        turned[s, methods], cost[s, methods] = heading[s, cheapest], cost[s, cheapest]
        step = 2.0 * TURN_MAX
        for _ in range(HALVINGS):
            step /= 2.0
            middle = turned[s, methods]
            for angle in (middle - step, middle + step):
                value = misalignment(segment, angle, ray, reach, flatness, along, across)
                if value < cost[s, methods]:
                    turned[s, methods], cost[s, methods] = angle, value
    return turned, cost
