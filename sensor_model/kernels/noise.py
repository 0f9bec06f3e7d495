"""Hot loops of the noise: thresholds, outages, rare events, and what is left of echoes that are too close."""

import math

import numpy as np
import numpy.typing as npt
from numba import njit

from sensor_model.arrays import Bools, Bytes, Floats, Ints, Key
from sensor_model.kernels.philox import philox, uniform

TABLE_BITS = 12
"""Of the tables from which draws are taken where a function would cost too much."""

_TABLE_SHIFT = np.uint64(32 - TABLE_BITS)


@njit(cache=True)
def beam_pairs(key: Key, frame: int, unit: Bytes, index: npt.NDArray[np.int32], beam: Ints, purpose: Ints) -> Floats:
    """(2, N) independent numbers in (0, 1) for N beams, from the counter (frame, unit, index, purpose).

    Parameters
    ----------
    unit, index
        (B,) a beam's unit and its index there.
    beam, purpose
        (N,) rows of the beam table, and what each draw is for, from 0 to 2^32 - 1.
    """
    pairs = np.empty((2, len(beam)))
    for i in range(len(beam)):
        words = philox(frame, unit[beam[i]], index[beam[i]], purpose[i], key[0], key[1])
        pairs[0, i] = uniform(words[0])
        pairs[1, i] = uniform(words[1])
    return pairs


@njit(cache=True)
def counter_pairs(key: Key, frame: Ints, first: Ints, second: Ints, purpose: Ints) -> Floats:
    """(2, N) independent numbers in (0, 1) for counters given by four arrays (N,), all from 0 to 2^32 - 1."""
    pairs = np.empty((2, len(frame)))
    for i in range(len(frame)):
        words = philox(frame[i], first[i], second[i], purpose[i], key[0], key[1])
        pairs[0, i] = uniform(words[0])
        pairs[1, i] = uniform(words[1])
    return pairs


@njit(cache=True)
def soft_thresholds(
    key: Key, frame: int, purpose: int, unit: Bytes, index: npt.NDArray[np.int32],
    threshold: Floats, factor: Floats, random_rate: float,
) -> tuple[Floats, Bools]:  # fmt: skip
    """Threshold of every beam in one frame, and whether the beam is lost by chance.

    Parameters
    ----------
    unit, index
        (B,) a beam's unit and its index there.
    threshold
        (U,) of each unit.
    factor
        (2^`TABLE_BITS`,) equally likely factors by which a beam's threshold may differ from its unit's.
    random_rate
        Share lost by chance.
    """
    own, lost = np.empty(len(unit)), np.empty(len(unit), np.bool_)
    for i in range(len(unit)):
        words = philox(frame, unit[i], index[i], purpose, key[0], key[1])
        own[i] = threshold[unit[i]] * factor[words[0] >> _TABLE_SHIFT]
        lost[i] = uniform(words[1]) < random_rate
    return own, lost


@njit(cache=True)
def silent_units(key: Key, tick: int, purpose: int, units: int, failing: float, recovering: float) -> Bools:
    """(U,) state of a two-state chain per unit at a tick >= 0: True where silent.

    At each tick a draw p below `failing` silences the unit and one above 1 - `recovering` wakes it, whatever its state;
    others leave it. With failing + recovering < 1 this is the chain with those two transition probabilities, and the
    state is known from the last decisive draw alone (coupling from the past, Propp and Wilson 1996). Before tick 0 the
    state is drawn from the stationary distribution.
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


@njit(cache=True)
def rare_beams(key: Key, frame: int, purpose: int, unit_beam: Ints, rate: float) -> Ints:
    """(K,) beams to which something happens, each with probability `rate` > 0 and independently of all others.

    The gaps between such beams are geometric, so that only those that are found are drawn. unit_beam (U + 1,): unit u
    has beams unit_beam[u] to unit_beam[u + 1].
    """
    found = np.empty(unit_beam[-1], np.int64)
    count = 0
    missed = math.log1p(-rate) if rate < 1.0 else -math.inf
    for u in range(len(unit_beam) - 1):
        beam, draw = unit_beam[u], 0
        while True:
            gap = np.floor(math.log(_uniform(key, frame, u, draw, purpose)) / missed)
            if beam + gap >= unit_beam[u + 1]:
                break
            found[count] = beam + int(gap)
            beam = found[count] + 1
            count, draw = count + 1, draw + 1
    return found[:count].copy()


@njit(cache=True)
def separate_echoes(
    beam: Ints, range_: Floats, width: Floats, separation: Floats, echoes_max: Ints
) -> tuple[Bools, Floats]:
    """Which of N echoes, ordered by beam and range, a unit tells apart, and how wide they are then.

    Parameters
    ----------
    separation, echoes_max
        (N,) of each echo's unit: echoes that start nearer than this to the start of the one before are part of it, and
        only so many are kept, the nearest.
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


@njit(cache=True)
def _uniform(key: Key, frame: int, first: int, second: int, purpose: int) -> float:
    return uniform(philox(frame, first, second, purpose, key[0], key[1])[0])
