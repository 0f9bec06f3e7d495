"""Points in groups: order by group, key or bearing, means, extents, and nearness.

Points are (N, 2 or more) float64 in the ego frame [m]. Group g is rows offset[g] to offset[g + 1].
Sums have a fixed order, so that results do not depend on threads or a BLAS.
"""

import numpy as np

from luxloop import elementary
from luxloop.arrays import Bools, Floats, Ints
from luxloop.compiled import kernel

RUN = 8
"""Items of a run, which is sorted by insertion before runs are merged."""
RADIX_BITS = 11
RADIX = 1 << RADIX_BITS
"""Values of a digit of the radix sort: the columns of cells in range have one digit."""
SAME_BEARING = 1e-9
"""Weight of the range in the order of points, far below the angle between beams [rad/m]."""
BLOCK = 64
"""Points that are compared at once, without branches: the compiler vectorises this."""


@kernel()
def by_group(label: Ints, count: int) -> tuple[Ints, Ints]:
    """Return the indices of points with labels 0 to `count` - 1 by label and in their order, and starts (count + 1,).

    Points (N,) with a negative label are left out. A counting sort.
    """
    start = np.zeros(count + 1, np.int64)
    for i in range(len(label)):
        if label[i] >= 0:
            start[label[i] + 1] += 1
    for g in range(count):
        start[g + 1] += start[g]
    order, place = np.empty(start[count], np.int64), start.copy()
    for i in range(len(label)):
        if label[i] >= 0:
            order[place[label[i]]] = i
            place[label[i]] += 1
    return order, start


@kernel()
def positions(points: Floats, index: Ints) -> Floats:
    """(K, 2) x and y of the points (N, 2 or more) of `index` (K,) [m]."""
    found = np.empty((len(index), 2))
    for k in range(len(index)):
        found[k, 0], found[k, 1] = points[index[k], 0], points[index[k], 1]
    return found


@kernel()
def columns(points: Floats) -> tuple[Floats, Floats]:
    """(N,) x and y of points (N, 2 or more), each contiguous: loops over rows of unknown length are not vectorised."""
    return points[:, 0].copy(), points[:, 1].copy()


@kernel(error_model="numpy")
def means(points: Floats, label: Ints, count: int) -> Floats:
    """(count, 2) mean of each group of points (N, 2 or more); points with a negative label belong to no group."""
    mean, size = np.zeros((count, 2)), np.zeros(count)
    for i in range(len(points)):
        g = label[i]
        if g >= 0:
            mean[g, 0] += points[i, 0]
            mean[g, 1] += points[i, 1]
            size[g] += 1.0
    for g in range(count):
        mean[g, 0] /= size[g]
        mean[g, 1] /= size[g]
    return mean


@kernel()
def extents_along(points: Floats, label: Ints, count: int, directions: Floats) -> Floats:
    """(count, D) extent of each group of points (N, 2) along unit vectors (D, 2) [m]; -inf for groups without points.

    Points with a negative label belong to no group.
    """
    low, high = np.full((count, len(directions)), np.inf), np.full((count, len(directions)), -np.inf)
    for i in range(len(points)):
        g = label[i]
        if g >= 0:
            for d in range(len(directions)):
                place = points[i, 0] * directions[d, 0] + points[i, 1] * directions[d, 1]
                low[g, d], high[g, d] = min(low[g, d], place), max(high[g, d], place)
    for g in range(count):
        for d in range(len(directions)):
            high[g, d] -= low[g, d]
    return high


@kernel()
def by_key(key: Floats, offset: Ints) -> Ints:
    """(N,) indices of the items of group after group, by ascending key (N,) within one.

    Group g is items offset[g] to offset[g + 1]. A merge sort: keys of points are mostly a few ascending runs.
    """
    order, spare = np.arange(len(key)), np.empty(len(key), np.int64)
    for g in range(len(offset) - 1):
        for first in range(offset[g], offset[g + 1], RUN):
            insert_in_run(key, order, first, min(first + RUN, offset[g + 1]))
        width = RUN
        while width < offset[g + 1] - offset[g]:
            for first in range(offset[g], offset[g + 1] - width, 2 * width):
                merge_runs(key, order, spare, first, first + width, min(first + 2 * width, offset[g + 1]))
            width *= 2
    return order


@kernel()
def insert_in_run(key: Floats, order: Ints, first: int, end: int) -> None:
    """Sort places `first` to `end` of an order by key, in place, by insertion."""
    for k in range(first + 1, end):
        item, place = order[k], k
        while place > first and key[order[place - 1]] > key[item]:
            order[place] = order[place - 1]
            place -= 1
        order[place] = item


@kernel()
def merge_runs(key: Floats, order: Ints, spare: Ints, first: int, middle: int, end: int) -> None:
    """Merge two adjacent sorted runs of an order, in place; `spare` (N,) is a work array."""
    if key[order[middle - 1]] <= key[order[middle]]:
        return
    for k in range(first, middle):
        spare[k] = order[k]
    left, right = first, middle
    for k in range(first, end):
        if left == middle:
            break  # the rest is in place
        if right < end and key[order[right]] < key[spare[left]]:
            order[k] = order[right]
            right += 1
        else:
            order[k] = spare[left]
            left += 1


@kernel()
def by_number(number: Ints, order: Ints) -> Ints:
    """(N,) indices of the numbers (N,) by ascending number, those of equal ones as in `order` (N,): a radix sort."""
    rest, digit, largest = np.empty(len(number), np.int64), np.empty(len(number), np.int64), 0
    least = number[0] if len(number) > 0 else 0
    for i in range(len(number)):
        least = min(least, number[i])
    for i in range(len(number)):
        rest[i] = number[i] - least
        largest = max(largest, rest[i])
    while largest > 0:
        for k in range(len(order)):
            digit[k] = rest[order[k]] & (RADIX - 1)
        place, _ = by_group(digit, RADIX)
        ordered = np.empty(len(order), np.int64)
        for k in range(len(order)):
            ordered[k] = order[place[k]]
            rest[k] >>= RADIX_BITS
        order, largest = ordered, largest >> RADIX_BITS
    return order


@kernel(error_model="numpy")
def bearing_keys(points: Floats, offset: Ints) -> Floats:
    """(N,) keys that sort the points (N, 2 or more) of a segment by bearing from their mean, those of one by range.

    Segment s has points offset[s] to offset[s + 1].
    """
    key = np.empty(len(points))
    for s in range(len(offset) - 1):
        x, y, count = 0.0, 0.0, offset[s + 1] - offset[s]
        for i in range(offset[s], offset[s + 1]):
            x, y = x + points[i, 0], y + points[i, 1]
        x, y = x / count, y / count
        for i in range(offset[s], offset[s + 1]):
            across, ahead = x * points[i, 1] - y * points[i, 0], x * points[i, 0] + y * points[i, 1]
            key[i] = elementary.atan2(across, ahead) + SAME_BEARING * elementary.hypot(points[i, 0], points[i, 1])
    return key


@kernel()
def even_subset(points: Floats, offset: Ints, count: int) -> tuple[Ints, Ints]:
    """Return up to `count` points of each segment, evenly spaced along the outline that the ego sees.

    The order of the points of a segment has no effect: they are sorted by bearing from their mean.

    Parameters
    ----------
    points, offset
        (N, 2 or more) grouped by segment [m]; (S + 1,) first point of each segment, and N.

    Returns
    -------
    tuple
        Indices of the chosen points (K,), grouped by segment, and the first one of each segment (S + 1,), and K.
    """
    by_bearing, first = by_key(bearing_keys(points, offset), offset), np.zeros(len(offset), np.int64)
    chosen = np.empty(len(points), np.int64)
    for s in range(len(offset) - 1):
        size = offset[s + 1] - offset[s]
        kept = min(size, count)
        for rank in range(kept):
            chosen[first[s] + rank] = by_bearing[offset[s] + rank * size // kept]
        first[s + 1] = first[s] + kept
    return chosen[: first[-1]], first


@kernel()
def any_within(points: Floats, others: Floats, radius: Floats) -> Bools:
    """(P,) mask of points (P, 2) with one of the others (Q, 2) within their radius (P,).

    The search begins in the block that the last one ended in: successive points are near each other, and so are others.
    """
    found, x, y = np.zeros(len(points), np.bool_), others[:, 0].copy(), others[:, 1].copy()
    blocks, block = (len(others) + BLOCK - 1) // BLOCK, 0
    for i in range(len(points)):
        at_x, at_y, limit = points[i, 0], points[i, 1], radius[i] ** 2
        for _ in range(blocks):
            own_x, own_y = x[BLOCK * block : BLOCK * (block + 1)], y[BLOCK * block : BLOCK * (block + 1)]
            near = 0
            for j in range(len(own_x)):
                near += (own_x[j] - at_x) ** 2 + (own_y[j] - at_y) ** 2 <= limit
            if near > 0:
                found[i] = True
                break
            block = (block + 1) % blocks
    return found
