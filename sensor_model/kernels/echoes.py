"""Echo detection: from the light that returns to a beam to its echoes, as the unit's electronics do it.

Samples are those of `records.Samples`; echoes are columns of `echo` and `echo_id`, as in `records.ScanBuffers`.
"""

import math

from luxloop import elementary
from luxloop.arrays import Floats, Ints
from luxloop.compiled import kernel
from luxloop.sensor_model.kernels.records import POWER, RANGE, SURFACE, TARGET, WIDTH, Receiver

_START = 0.1  # [m] length of an echo's start, four sigma of a LUX: samples within it decide the echo's surface


@kernel()
def sort_by_range(sample: Floats, order: Ints, begin: int, end: int) -> None:
    """Sort the ranges of samples [begin, end) in place, near to far; `order` (S,) out: sample of each sorted range.

    Insertion sort, because the samples come nearly sorted. Only ranges move; `order` finds the other columns.
    """
    for i in range(begin, end):
        r, k = sample[RANGE, i], i
        while k > begin and sample[RANGE, k - 1] > r:
            sample[RANGE, k], order[k] = sample[RANGE, k - 1], order[k - 1]
            k -= 1
        sample[RANGE, k], order[k] = r, i


@kernel(inline="always")
def find_strong_echo(
    sample: Floats, sample_id: Ints, begin: int, end: int, threshold: float, receiver: Receiver, beam: int,
    echo: Floats, echo_id: Ints,
) -> bool:  # fmt: skip
    """Set the echo of a beam on one surface whose samples all reach the threshold alone, within one pulse length.

    The echo is that of `find_echoes`: it starts at the nearest sample, and ends one pulse after the farthest.

    Returns
    -------
    False, with nothing set, for all other beams.
    """
    nearest, farthest, weakest, total = sample[RANGE, begin], sample[RANGE, begin], sample[POWER, begin], 0.0
    same = True
    for i in range(begin, end):
        nearest, farthest = min(nearest, sample[RANGE, i]), max(farthest, sample[RANGE, i])
        weakest, total = min(weakest, sample[POWER, i]), total + sample[POWER, i]
        same &= sample_id[SURFACE, i] == sample_id[SURFACE, begin]
        same &= sample_id[TARGET, i] == sample_id[TARGET, begin]
    if not same or weakest < threshold or farthest >= nearest + receiver.pulse_length:
        return False
    growth = receiver.pulse_growth * 10.0 * elementary.log10(total / threshold)
    echo[RANGE, beam, 0], echo[POWER, beam, 0] = nearest, total
    echo[WIDTH, beam, 0] = farthest + receiver.pulse_length - nearest + growth
    echo_id[TARGET, beam, 0], echo_id[SURFACE, beam, 0] = sample_id[TARGET, begin], sample_id[SURFACE, begin]
    return True


@kernel()
def find_echoes(
    sample: Floats, order: Ints, begin: int, end: int, threshold: float, receiver: Receiver, beam: int, echo: Floats
) -> tuple[int, float, float]:
    """Set range, power and width of the echoes of a beam.

    The receiver sums the power within one pulse length. An echo starts where the sum reaches the threshold, and ends
    where it falls below. An echo that starts too close to the previous one merges with it.

    Parameters
    ----------
    sample, order
        As sorted by `sort_by_range`.
    begin, end
        The beam has samples [begin, end), at least one.
    threshold
        Minimum power of an echo [1/m^2].

    Returns
    -------
    Number of echoes, highest power [1/m^2], and its range [m].
    """
    used, oldest, newest = 0, begin, begin
    total, highest, where, above = 0.0, 0.0, sample[RANGE, begin], False
    while newest < end or above:
        leaves = sample[RANGE, oldest] + receiver.pulse_length if oldest < newest else math.inf
        if newest == end or leaves <= sample[RANGE, newest]:
            total -= sample[POWER, order[oldest]]
            oldest += 1
            if oldest == newest:
                total = 0.0  # removes rounding residues
            if above and total < threshold:
                above = False
                echo[WIDTH, beam, used - 1] = leaves - echo[RANGE, beam, used - 1]
            continue
        at = sample[RANGE, newest]
        while newest < end and sample[RANGE, newest] == at:
            total += sample[POWER, order[newest]]
            newest += 1
        if total > highest:
            highest, where = total, at
        if not above and total >= threshold:
            above = True
            apart = used == 0 or at - echo[RANGE, beam, used - 1] >= receiver.echo_separation
            if apart and used == receiver.echoes_max:
                break
            if apart:
                echo[RANGE, beam, used], echo[POWER, beam, used] = at, 0.0
                used += 1
        if above:
            echo[POWER, beam, used - 1] = max(echo[POWER, beam, used - 1], total)
    for e in range(used):
        echo[WIDTH, beam, e] += receiver.pulse_growth * 10.0 * elementary.log10(echo[POWER, beam, e] / threshold)
    return used, highest, where


@kernel()
def label_echo(
    sample: Floats, sample_id: Ints, order: Ints, begin: int, end: int, beam: int, e: int, echo: Floats,
    echo_id: Ints,
) -> None:  # fmt: skip
    """Set target and surface of echo e of a beam to those with the most power at its start; the nearer one in a tie."""
    first, last, whole = end, begin, 0.0
    for i in range(begin, end):
        if echo[RANGE, beam, e] <= sample[RANGE, i] < echo[RANGE, beam, e] + _START:
            first, last = min(first, i), i + 1
            whole += sample[POWER, order[i]]
    most = -1.0
    for i in range(first, last):
        target, surface, total = sample_id[TARGET, order[i]], sample_id[SURFACE, order[i]], 0.0
        for k in range(i, last):
            if sample_id[TARGET, order[k]] == target and sample_id[SURFACE, order[k]] == surface:
                total += sample[POWER, order[k]]
        if total > most:
            most, echo_id[TARGET, beam, e], echo_id[SURFACE, beam, e] = total, target, surface
        if 2.0 * most > whole:  # the remaining samples cannot exceed it
            break
