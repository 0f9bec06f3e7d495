"""Kernels of the noise: random draws, thresholds, outages, rare events, and merging of close echoes."""

import math

import numpy as np
import numpy.typing as npt

from luxloop import elementary
from luxloop.arrays import Bools, Bytes, Floats, Ints
from luxloop.compiled import kernel
from luxloop.sensor_model.kernels.philox import Key, philox, uniform

TABLE_BITS = 12
"""Bits of the index into lookup tables that replace costly functions of a random number."""

_TABLE_SHIFT = np.uint64(32 - TABLE_BITS)


@kernel()
def beam_pairs(key: Key, frame: int, unit: Bytes, index: npt.NDArray[np.int32], beam: Ints, purpose: Ints) -> Floats:
    """Return (2, N) independent numbers in (0, 1) for N beams, from the counter (frame, unit, index, purpose).

    Parameters
    ----------
    unit, index
        (B,) unit of each beam, and index in that unit.
    beam, purpose
        (N,) rows of the beam table, and purpose of each draw, from 0 to 2^32 - 1.
    """
    pairs = np.empty((2, len(beam)))
    first, second = np.empty(len(beam), np.int64), np.empty(len(beam), np.int64)
    for i in range(len(beam)):  # apart from the draws, whose loop is vectorised
        first[i], second[i] = unit[beam[i]], index[beam[i]]
    for i in range(len(beam)):
        words = philox(frame, first[i], second[i], purpose[i], key[0], key[1])
        pairs[0, i] = uniform(words[0])
        pairs[1, i] = uniform(words[1])
    return pairs


@kernel()
def counter_pairs(key: Key, frame: Ints, first: Ints, second: Ints, purpose: Ints) -> Floats:
    """Return (2, N) independent numbers in (0, 1) for counters given by four arrays (N,), all from 0 to 2^32 - 1."""
    pairs = np.empty((2, len(frame)))
    for i in range(len(frame)):
        words = philox(frame[i], first[i], second[i], purpose[i], key[0], key[1])
        pairs[0, i] = uniform(words[0])
        pairs[1, i] = uniform(words[1])
    return pairs


@kernel()
def soft_thresholds(
    key: Key, frame: int, purpose: int, unit: Bytes, index: npt.NDArray[np.int32],
    threshold: Floats, factor: Floats, random_rate: float,
) -> tuple[Floats, Bools]:  # fmt: skip
    """Return the (B,) threshold of each beam in one frame, and the (B,) mask of beams lost at random.

    Parameters
    ----------
    unit, index
        (B,) unit of each beam, and index in that unit.
    threshold
        (U,) threshold of each unit.
    factor
        (2^`TABLE_BITS`,) equally likely ratios of a beam's threshold to its unit's.
    random_rate
        Probability that a beam is lost at random.
    """
    thresholds, lost = np.empty(len(unit)), np.empty(len(unit), np.bool_)
    row, chance = np.empty(len(unit), np.uint64), np.empty(len(unit))
    for i in range(len(unit)):  # apart from the look-up, so that the compiler vectorises it
        words = philox(frame, unit[i], index[i], purpose, key[0], key[1])
        row[i], chance[i] = words[0] >> _TABLE_SHIFT, uniform(words[1])
    for i in range(len(unit)):
        thresholds[i], lost[i] = threshold[unit[i]] * factor[row[i]], chance[i] < random_rate
    return thresholds, lost


@kernel()
def silent_units(key: Key, tick: int, purpose: int, units: int, failing: float, recovering: float) -> Bools:
    """Return the (U,) state of a two-state Markov chain per unit at a tick >= 0: True if silent.

    At each tick a draw p below `failing` silences the unit, and one above 1 - `recovering` restores it, in either
    state; other draws leave it unchanged. With failing + recovering < 1 this is the chain with those transition
    probabilities, and the last decisive draw alone determines the state (coupling from the past, Propp and Wilson
    1996). The state before tick 0 is drawn from the stationary distribution.
    """
    silent = np.empty(units, np.bool_)
    for u in range(units):
        silent[u] = _uniform(key, 0, u, 0, purpose) * (failing + recovering) < failing
        for t in range(tick, -1, -1):
            p = _uniform(key, t + 1, u, 0, purpose)
            if p < failing or p > 1.0 - recovering:
                silent[u] = p < failing
                break
    return silent


@kernel()
def rare_beams(key: Key, frame: int, purpose: int, unit_beam: Ints, rate: float) -> Ints:
    """Return (K,) randomly selected beams, each with probability `rate` > 0 and independently of all others.

    The gaps between selected beams are geometric, so the cost is one draw per selected beam.

    Parameters
    ----------
    unit_beam
        (U + 1,) unit u has beams unit_beam[u] to unit_beam[u + 1].
    """
    found = np.empty(unit_beam[-1], np.int64)
    count = 0
    missed = elementary.log1p(-rate) if rate < 1.0 else -math.inf
    for u in range(len(unit_beam) - 1):
        beam, draw = unit_beam[u], 0
        while True:
            gap = np.floor(elementary.log(_uniform(key, frame, u, draw, purpose)) / missed)
            if beam + gap >= unit_beam[u + 1]:
                break
            found[count] = beam + int(gap)
            beam = found[count] + 1
            count, draw = count + 1, draw + 1
    return found[:count].copy()


@kernel()
def separate_echoes(
    beam: Ints, range_: Floats, width: Floats, separation: Floats, echoes_max: Ints
) -> tuple[Bools, Floats]:
    """Return the (N,) mask of echoes that a unit reports, and their (N,) widths after merging [m].

    The echoes come ordered by beam and range.

    Parameters
    ----------
    separation, echoes_max
        (N,) of each echo's unit: an echo that starts closer than this to the start of the previous one merges with it,
        and of the others the nearest `echoes_max` are kept.
    """
    kept, merged = np.zeros(len(beam), np.bool_), width.copy()
    last, count = -1, 0
    for i in range(len(beam)):
        if last < 0 or beam[i] != beam[last]:
            count = 0
        elif range_[i] - range_[last] < separation[i]:
            merged[last] = max(merged[last], range_[i] + width[i] - range_[last])
            continue
        elif count == echoes_max[i]:
            continue
        kept[i] = True
        last, count = i, count + 1
    return kept, merged


@kernel()
def _uniform(key: Key, frame: int, first: int, second: int, purpose: int) -> float:
    return uniform(philox(frame, first, second, purpose, key[0], key[1])[0])
