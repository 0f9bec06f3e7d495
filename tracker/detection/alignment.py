"""Alignment of the points of a segment along and across a heading: the density of their projections."""

import math

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats, Ints
from luxloop.compiled import kernel

REACH_M = 0.08
"""Spread of points across a perpendicular side [m], as `linkage.tau_m`: two steps of the LUX's resolution. Range noise
is along the beam: across an oblique side there is less of it."""
FLATNESS_M = 0.03
"""Spread across a side at grazing incidence [m], without range noise. A LUX beam is 2.8 cm wide at 20 m, a standard
deviation of 0.8 cm, and panels are flat to the same amount."""
BINS_PER_REACH = 4
"""Bins per kernel radius: a bin is two thirds of the kernel's standard deviation."""
BESIDE = (0.87890625, 0.5625, 0.19140625)
"""Kernel at one, two and three bins from its middle: (1 - (d / BINS_PER_REACH)^2)^2."""
TURN_MAX = math.radians(2.0)
"""First step of the refinement [rad]; all steps together turn a heading by at most twice as much."""
HALVINGS = 7
"""Steps of the refinement; the last is 1/32 of a degree."""


@kernel(inline="always", error_model="numpy")
def smoothed(count: Floats, node: int) -> float:
    """Return the sum of the bins about a node, weighted by the kernel."""
    first, second, third = BESIDE
    total: float = count[node] + first * (count[node - 1] + count[node + 1])
    total += second * (count[node - 2] + count[node + 2])
    total += third * (count[node - 3] + count[node + 3])
    return total


@kernel(error_model="numpy")
def local_density(place: Floats, reach: float, out: Floats) -> None:
    """Write the kernel density of the other points at each point's place to `out`, which may be `place` itself.

    A point at distance d counts (1 - (d / reach)^2)^2, a kernel with a standard deviation of 0.38 reach; the point
    itself does not count. Each place is interpolated between the two bins around it, for writing and reading, so that
    the estimate is continuous and needs no sorting.
    """
    low, high, pitch = place[0], place[0], reach / BINS_PER_REACH
    for i in range(1, len(place)):
        low, high = min(low, place[i]), max(high, place[i])
    count = np.zeros(int((high - low) / pitch) + 2 * BINS_PER_REACH + 2)
    for i in range(len(place)):
        at = (place[i] - low) / pitch + BINS_PER_REACH
        node = int(at)
        count[node] += 1.0 - (at - node)
        count[node + 1] += at - node
        out[i] = at
    for i in range(len(place)):
        node = int(out[i])
        share = out[i] - node
        own = (1.0 - share) ** 2 + share**2 + 2.0 * share * (1.0 - share) * BESIDE[0]
        out[i] = (1.0 - share) * smoothed(count, node) + share * smoothed(count, node + 1) - own


@kernel(error_model="numpy")
def sharpness(normal_x: float, normal_y: float, ray: Floats, reach: float, flatness: float) -> float:
    """Kernel radius across a side with that normal: range noise along the unit vector `ray`, projected on the normal.

    It is `flatness` at grazing incidence, and largest, with `reach`, at normal incidence.
    """
    return elementary.hypot(reach * (normal_x * ray[0] + normal_y * ray[1]), flatness)


@kernel(error_model="numpy")
def misalignment(
    points: Floats, heading: float, ray: Floats, reach: float, flatness: float, along: Floats, across: Floats
) -> float:
    """Cost of a heading: minus the mean over the points of log(1 + density), on lines along the heading or across it.

    Points on a side have a high density on its line; of the two densities per radius the higher is that of the point's
    side. `along` and `across` are work arrays (N,).
    """
    cos, sin = elementary.cos(heading), elementary.sin(heading)
    reach_along = sharpness(cos, sin, ray, reach, flatness)
    reach_across = sharpness(-sin, cos, ray, reach, flatness)
    for i in range(len(points)):
        x, y = points[i, 0], points[i, 1]
        along[i], across[i] = cos * x + sin * y, cos * y - sin * x
    local_density(along, reach_along, along)
    local_density(across, reach_across, across)
    total = 0.0
    for i in range(len(points)):
        total += elementary.log(1.0 + reach * max(along[i] / reach_along, across[i] / reach_across))
    return -total / len(points)


@kernel(error_model="numpy")
def misalignments(
    points: Floats, offset: Ints, heading: Floats, owner: Ints, ray: Floats, reach: float, flatness: float
) -> Floats:
    """(K,) cost of headings (K,) for the points of segments `owner` (K,); see `misalignment`.

    Segment s has points offset[s] to offset[s + 1] in the direction ray[s]. See `sharpness` for reach and flatness.
    """
    cost, along, across = np.empty(len(heading)), np.empty(len(points)), np.empty(len(points))
    for k in range(len(heading)):
        first, end, s = offset[owner[k]], offset[owner[k] + 1], owner[k]
        cost[k] = misalignment(
            points[first:end], heading[k], ray[s], reach, flatness, along[first:end], across[first:end]
        )
    return cost


@kernel(error_model="numpy")
def align(points: Floats, offset: Ints, heading: Floats, reach: float, flatness: float) -> tuple[Floats, Floats]:
    """Refine the best of each segment's headings (S, M) to the minimum of the cost; the sensor is at the origin.

    Returns the headings (S, M + 1), the refined one last, and their costs.
    """
    segments, methods = heading.shape
    turned, cost = np.empty((segments, methods + 1)), np.empty((segments, methods + 1))
    turned[:, :methods] = heading
    for s in range(segments):
        segment = points[offset[s] : offset[s + 1]]
        along, across = np.empty(len(segment)), np.empty(len(segment))
        bearing = elementary.atan2(segment[:, 1].mean(), segment[:, 0].mean())
        ray = np.array([elementary.cos(bearing), elementary.sin(bearing)])
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
