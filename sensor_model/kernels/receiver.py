"""Receivers of the units: from the hits of the rays of a fan to the light that returns, and to the echoes of its beams.

Echoes are detected as the unit's electronics do it. Samples are those of `records.Samples`; echoes are columns of
`echo` and `echo_id`, as in `records.ScanBuffers`.
"""

import math

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats, Ints
from luxloop.compiled import kernel
from luxloop.sensor_model.kernels.records import (
    COSINE,
    INNER_COSINE,
    INNER_INVERSE_DEPTH,
    INNER_SURFACE,
    INVERSE_DEPTH,
    NONE,
    POWER,
    RANGE,
    SURFACE,
    TARGET,
    WIDTH,
    Beams,
    Rays,
    Receiver,
    Samples,
    ScanBuffers,
    Solids,
    StaticScene,
    Units,
)
from luxloop.sensor_model.returns import GROUND, NOTHING, WALL


@kernel(error_model="numpy")
def gather_samples(
    rays: Rays, layer: int, gain: Floats, receiver: Receiver, bodies: Solids, static: StaticScene, samples: Samples,
    hits: Ints,
) -> None:  # fmt: skip
    """Fill the samples of the beams of one layer of a block, beam after beam, and count the rays that end on bodies.

    Power is reflectivity x cos(incidence) x gain / range^2 (Lambert), attenuated by the air, in equal shares per ray.

    Parameters
    ----------
    gain
        (K,) sensitivity of each beam.
    hits
        (A,) in and out: rays that end on each body.
    """
    # Unpacked once: each access to a record's array costs an atomic reference count.
    line, cos, hit, hit_id, value, ids = rays.line, rays.cos, rays.hit, rays.hit_id, samples.value, samples.id
    targets, inverse_depth, inner_surface = hit_id[TARGET], hit[INVERSE_DEPTH], hit_id[INNER_SURFACE]
    start, blocked = samples.start, samples.blocked
    wall_reflectivity, reflectivity, transmission = static.reflectivity, bodies.reflectivity, bodies.transmission
    ground_reflectivity, extinction, range_min = static.ground_reflectivity, static.extinction, receiver.range_min
    per_beam, count, flat = rays.side.shape[1], 0, len(static.ground.height) == 0
    for k in range(len(gain)):
        share, blocked[k] = gain[k] / per_beam, False
        for r in range(per_beam):
            target = targets[k, layer, r]
            if target == NOTHING:
                continue
            if target >= 0:
                hits[target] += 1
            at = 1.0 / (inverse_depth[k, layer, r] * cos[k, layer, r])
            if at < range_min:
                blocked[k] = True
                continue
            if target == GROUND:
                q, sent = 0, ground_reflectivity * (line[2, k] / at if flat else hit[COSINE, k, layer, r])
            else:
                q = hit_id[SURFACE, k, layer, r]
                sent = (wall_reflectivity[q] if target == WALL else reflectivity[q]) * hit[COSINE, k, layer, r]
            count = _append(target, q, at, sent * share, extinction, value, ids, count)
            behind = inner_surface[k, layer, r]
            if behind != NONE:
                sent = transmission[q] * reflectivity[behind] * hit[INNER_COSINE, k, layer, r]
                at = 1.0 / (hit[INNER_INVERSE_DEPTH, k, layer, r] * cos[k, layer, r])
                count = _append(target, behind, at, sent * share, extinction, value, ids, count)
        start[k + 1] = count


@kernel(error_model="numpy")
def _append(
    target: int, surface: int, r: float, sent: float, extinction: float, value: Floats, ids: Ints, count: int
) -> int:
    """Append a sample; return the number of samples."""
    air = elementary.exp(-2.0 * extinction * r) if extinction > 0.0 else 1.0
    value[RANGE, count], value[POWER, count] = r, sent / (r * r) * air
    ids[TARGET, count], ids[SURFACE, count] = target, surface
    return count + 1


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


@kernel()
def receive_block(
    u: int, first_beam: Ints, first: int, beams: Beams, units: Units, bodies: Solids, static: StaticScene, rays: Rays,
    out: ScanBuffers,
) -> None:  # fmt: skip
    """Set the echoes of the beams of a block of a fan of unit u, and the lost beams.

    Parameters
    ----------
    first_beam
        First beam of each layer of the fan.
    first
        Index of the block's first azimuth in the fan.
    """
    azimuths, per_beam = len(rays.cos), rays.side.shape[1]
    receiver = Receiver(
        units.range_min[u], units.pulse_length[u], units.pulse_growth[u], units.echo_separation[u], units.echoes_max[u]
    )
    samples = _work_arrays(azimuths * 2 * per_beam, azimuths)
    for layer in range(len(first_beam)):
        begin = first_beam[layer] + first
        gain, threshold = beams.gain[begin : begin + azimuths], beams.threshold[begin : begin + azimuths]
        gather_samples(rays, layer, gain, receiver, bodies, static, samples, out.unit_hits[u])
        _detect_echoes(begin, threshold, receiver, samples, out)


@kernel()
def _work_arrays(room: int, beams: int) -> Samples:
    """Return samples for so many beams with so many samples in all."""
    return Samples(
        np.empty((2, room)), np.empty((2, room), np.int64), np.empty(room, np.int64),
        np.zeros(beams + 1, np.int64), np.empty(beams, np.bool_),
    )  # fmt: skip


@kernel()
def _detect_echoes(first: int, threshold: Floats, receiver: Receiver, samples: Samples, out: ScanBuffers) -> None:
    """Set the echoes of successive beams, and those that hit something and have none.

    Parameters
    ----------
    first
        First beam.
    threshold
        (K,) minimum power of an echo, per beam [1/m^2].
    """
    # Unpacked once: each access to a record's array costs an atomic reference count.
    value, ids, order, start, blocked = samples
    echo, echo_id, count, lost, lost_echo = out.echo, out.echo_id, out.echoes, out.lost, out.lost_echo
    for k in range(len(threshold)):
        begin, end, beam = start[k], start[k + 1], first + k
        found, highest, where = 0, 0.0, 0.0
        if begin < end:
            if find_strong_echo(value, ids, begin, end, threshold[k], receiver, beam, echo, echo_id):
                count[beam] = 1
                continue
            sort_by_range(value, order, begin, end)
            found, highest, where = find_echoes(value, order, begin, end, threshold[k], receiver, beam, echo)
        for e in range(found):
            label_echo(value, ids, order, begin, end, beam, e, echo, echo_id)
        count[beam] = found
        if found == 0 and (begin < end or blocked[k]):
            lost[beam], lost_echo[RANGE, beam], lost_echo[POWER, beam] = True, where, highest
