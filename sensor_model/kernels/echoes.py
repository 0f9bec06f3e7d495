"""From what comes back to a beam to its echoes: the unit's electronics.

What comes back along one ray is a sample: a column of `sample` and of `sample_id`. So are echoes, of `echo` and
`echo_id`.
"""

import math

from numba import njit

from sensor_model.arrays import Floats, Ints

RANGE, POWER, WIDTH = range(3)
"""Rows of `sample` (range, power) and `echo` (all)."""
TARGET, SURFACE, BEAM = range(3)
"""Rows of `sample_id` (target, surface) and `echo_id` (all)."""
_START = 0.1  # [m] of an echo: nearer than that to its range a surface is what is there, at four sigma of a LUX


@njit(cache=True)
def sort_by_range(sample: Floats, order: Ints, n: int) -> None:
    """Sort the ranges of the first n samples, near to far, in place; `order` (n,) out: which sample each is of.

    They come nearly sorted. Only ranges move, the rest of a sample is found by `order`.
    """
    for i in range(n):
        r, k = sample[RANGE, i], i
        while k > 0 and sample[RANGE, k - 1] > r:
            sample[RANGE, k], order[k] = sample[RANGE, k - 1], order[k - 1]
            k -= 1
        sample[RANGE, k], order[k] = r, i


@njit(cache=True)
def find_echoes(
    sample: Floats, order: Ints, n: int, threshold: float, pulse_length: float, pulse_growth: float,
    separation: float, most: int, echo: Floats, used: int,
) -> tuple[int, float, float]:  # fmt: skip
    """Append the echoes of a beam, all but their names.

    The unit adds up what comes back within one pulse length. An echo starts where the sum reaches the threshold, and
    ends where it falls below; echoes that start too near the one before merge with it.

    Parameters
    ----------
    sample, order
        As `sort_by_range` leaves them.
    n
        The beam has so many samples.
    threshold, pulse_length, pulse_growth, separation, most
        Power [1/m^2]; lengths [m], growth [m/dB]; how many echoes the unit reports.
    used
        Echoes in the tables so far.

    Returns
    -------
    How many echoes there are now, the highest power [1/m^2], and the range at which it was reached [m].
    """
    begin, oldest, newest = used, 0, 0
    total, highest, where, above = 0.0, 0.0, sample[RANGE, 0], False
    while newest < n or above:
        leaves = sample[RANGE, oldest] + pulse_length if oldest < newest else math.inf
        if newest == n or leaves <= sample[RANGE, newest]:
            total -= sample[POWER, order[oldest]]
            oldest += 1
            if oldest == newest:
                total = 0.0  # rounding must leave nothing behind
            if above and total < threshold:
                above = False
                echo[WIDTH, used - 1] = leaves - echo[RANGE, used - 1]
            continue
        at = sample[RANGE, newest]
        while newest < n and sample[RANGE, newest] == at:
            total += sample[POWER, order[newest]]
            newest += 1
        if total > highest:
            highest, where = total, at
        if not above and total >= threshold:
            above = True
            apart = used == begin or at - echo[RANGE, used - 1] >= separation
            if apart and used - begin == most:
                break
            if apart:
                echo[RANGE, used], echo[POWER, used] = at, 0.0
                used += 1
        if above:
            echo[POWER, used - 1] = max(echo[POWER, used - 1], total)
    for e in range(begin, used):
        echo[WIDTH, e] += pulse_growth * 10.0 * math.log10(echo[POWER, e] / threshold)
    return used, highest, where


@njit(cache=True)
def name_echo(sample: Floats, sample_id: Ints, order: Ints, n: int, echo: Floats, echo_id: Ints, e: int) -> None:
    """Set target and surface of echo e: those with most power where it starts; of equals, the nearer."""
    first, end, whole = n, 0, 0.0
    for i in range(n):
        if echo[RANGE, e] <= sample[RANGE, i] < echo[RANGE, e] + _START:
            first, end = min(first, i), i + 1
            whole += sample[POWER, order[i]]
    most = -1.0
    for i in range(first, end):
        target, surface, total = sample_id[TARGET, order[i]], sample_id[SURFACE, order[i]], 0.0
        for k in range(i, end):
            if sample_id[TARGET, order[k]] == target and sample_id[SURFACE, order[k]] == surface:
                total += sample[POWER, order[k]]
        if total > most:
            most, echo_id[TARGET, e], echo_id[SURFACE, e] = total, target, surface
        if 2.0 * most > whole:  # no other has more
            break
