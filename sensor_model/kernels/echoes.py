"""From what comes back to a beam to its echoes: the unit's electronics.

What comes back along one ray is a sample: a row of `sample` and of `sample_id`. So are echoes, of `echo` and `echo_id`.
"""

import math

from numba import njit

from sensor_model.kernels.records import Floats, Ints

RANGE, POWER, WIDTH = range(3)
"""Columns of `sample` (range, power) and `echo` (all)."""
TARGET, SURFACE, BEAM = range(3)
"""Columns of `sample_id` (target, surface) and `echo_id` (all)."""


@njit(cache=True)
def sort_by_range(sample: Floats, sample_id: Ints, n: int) -> None:
    """Sort the first n samples from near to far, in place; they come nearly sorted."""
    for i in range(1, n):
        r, p = sample[i, RANGE], sample[i, POWER]
        target, surface = sample_id[i, TARGET], sample_id[i, SURFACE]
        k = i
        while k > 0 and sample[k - 1, RANGE] > r:
            sample[k, RANGE], sample[k, POWER] = sample[k - 1, RANGE], sample[k - 1, POWER]
            sample_id[k, TARGET], sample_id[k, SURFACE] = sample_id[k - 1, TARGET], sample_id[k - 1, SURFACE]
            k -= 1
        sample[k, RANGE], sample[k, POWER] = r, p
        sample_id[k, TARGET], sample_id[k, SURFACE] = target, surface


@njit(cache=True)
def find_echoes(
    sample: Floats, sample_id: Ints, n: int, threshold: float, pulse_length: float, pulse_growth: float,
    separation: float, most: int, echo: Floats, echo_id: Ints, used: int,
) -> tuple[int, float, float]:  # fmt: skip
    """Append the echoes of a beam, all but their names.

    The unit adds up what comes back within one pulse length. An echo starts where the sum reaches the threshold, and
    ends where it falls below; echoes that start too near the one before merge with it.

    Parameters
    ----------
    n
        The beam has so many samples, from near to far.
    threshold, pulse_length, pulse_growth, separation, most
        Power [1/m^2]; lengths [m], growth [m/dB]; how many echoes the unit reports.
    used
        Echoes in the tables so far.

    Returns
    -------
    How many echoes there are now, the highest power [1/m^2], and the range at which it was reached [m].
    """
    begin, oldest, newest = used, 0, 0
    total, highest, where, above = 0.0, 0.0, 0.0, False
    while newest < n or above:
        leaves = sample[oldest, RANGE] + pulse_length if oldest < newest else math.inf
        if newest == n or leaves <= sample[newest, RANGE]:
            total -= sample[oldest, POWER]
            oldest += 1
            if oldest == newest:
                total = 0.0  # rounding must leave nothing behind
            if above and total < threshold:
                above = False
                echo[used - 1, WIDTH] = leaves - echo[used - 1, RANGE]
            continue
        at = sample[newest, RANGE]
        while newest < n and sample[newest, RANGE] == at:
            total += sample[newest, POWER]
            newest += 1
        if total > highest:
            highest, where = total, at
        if not above and total >= threshold:
            above = True
            apart = used == begin or at - echo[used - 1, RANGE] >= separation
            if apart and used - begin == most:
                break
            if apart:
                echo[used, RANGE], echo[used, POWER] = at, 0.0
                used += 1
        if above:
            echo[used - 1, POWER] = max(echo[used - 1, POWER], total)
    for e in range(begin, used):
        echo[e, WIDTH] += pulse_growth * 10.0 * math.log10(echo[e, POWER] / threshold)
    return used, highest, where


@njit(cache=True)
def name_echo(sample: Floats, sample_id: Ints, n: int, pulse_length: float, echo: Floats, echo_id: Ints, e: int) -> None:
    """Set target and surface of echo e: those with most power in its first pulse length; of equals, the nearer."""
    first, end, whole = n, 0, 0.0
    for i in range(n):
        if echo[e, RANGE] <= sample[i, RANGE] < echo[e, RANGE] + pulse_length:
            first, end = min(first, i), i + 1
            whole += sample[i, POWER]
    most = -1.0
    for i in range(first, end):
        total = 0.0
        for k in range(i, end):
            if sample_id[k, TARGET] == sample_id[i, TARGET] and sample_id[k, SURFACE] == sample_id[i, SURFACE]:
                total += sample[k, POWER]
        if total > most:
            most = total
            echo_id[e, TARGET], echo_id[e, SURFACE] = sample_id[i, TARGET], sample_id[i, SURFACE]
        if 2.0 * most > whole:  # no other has more
            break
