"""Kernels of stable sorting: items of groups by a key, and items by a whole number."""

import numpy as np

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.compiled import kernel
from luxloop.tracker.detection.kernels.groups import by_group

RUN = 8
"""Items of a run, which is sorted by insertion before runs are merged."""
RADIX_BITS = 11
RADIX = 1 << RADIX_BITS
"""Values of a digit of the radix sort: the columns of cells in range have one digit."""


@kernel()
def by_key(key: Floats, offset: Ints) -> Ints:
    """(N,) indices of the items of group after group, by ascending key (N,) within one.

    Group g is items offset[g] to offset[g + 1]. A merge sort: keys of points are mostly a few ascending runs.
    """
    order, spare = np.arange(len(key)), np.empty(len(key), np.int64)
    for g in range(len(offset) - 1):
        for first in range(offset[g], offset[g + 1], RUN):
            insert(key, order, first, min(first + RUN, offset[g + 1]))
        width = RUN
        while width < offset[g + 1] - offset[g]:
            for first in range(offset[g], offset[g + 1] - width, 2 * width):
                merge(key, order, spare, first, first + width, min(first + 2 * width, offset[g + 1]))
            width *= 2
    return order


@kernel()
def insert(key: Floats, order: Ints, first: int, end: int) -> None:
    """Sort places `first` to `end` of an order by key, in place, by insertion."""
    for k in range(first + 1, end):
        item, place = order[k], k
        while place > first and key[order[place - 1]] > key[item]:
            order[place] = order[place - 1]
            place -= 1
        order[place] = item


@kernel()
def merge(key: Floats, order: Ints, spare: Ints, first: int, middle: int, end: int) -> None:
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
