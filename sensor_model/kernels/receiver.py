"""Receivers of the units: from the hits of the rays of a fan to the echoes of its beams."""

import numpy as np
from numba import njit

from sensor_model.arrays import Floats, Ints
from sensor_model.kernels.echoes import find_echoes, label_echo, sort_by_range
from sensor_model.kernels.records import (
    BEAM,
    POWER,
    RANGE,
    Beams,
    Rays,
    Receiver,
    Samples,
    ScanBuffers,
    Solids,
    StaticScene,
    Units,
)
from sensor_model.kernels.samples import gather_samples

_SAMPLES = 4096  # beams are processed in blocks of at most this many samples, so that these stay in the cache


@njit(cache=True)
def receive_fan(
    u: int, first_beam: Ints, beams: Beams, units: Units, bodies: Solids, static: StaticScene, rays_wide: int,
    rays: Rays, out: ScanBuffers,
) -> None:  # fmt: skip
    """Append the echoes and the lost beams of a fan of unit u to `out`.

    Parameters
    ----------
    first_beam
        First beam of each layer.
    """
    columns, n = rays.cos.shape
    rays_high, azimuths = n // len(first_beam), columns // rays_wide
    receiver = Receiver(
        units.range_min[u], units.pulse_length[u], units.pulse_growth[u], units.echo_separation[u], units.echoes_max[u]
    )
    per_beam = 2 * rays_high * rays_wide
    block = min(azimuths, max(1, _SAMPLES // per_beam))
    samples = _work_arrays(block * per_beam, block)
    for layer in range(len(first_beam)):
        low, high = layer * rays_high, (layer + 1) * rays_high
        for k in range(0, azimuths, block):
            first, end = first_beam[layer] + k, first_beam[layer] + min(k + block, azimuths)
            gather_samples(rays, low, high, k, rays_wide, beams.gain[first:end], receiver, bodies, static, samples)
            _detect_echoes(first, beams.threshold[first:end], receiver, samples, out)


@njit(cache=True)
def _work_arrays(room: int, beams: int) -> Samples:
    """Return samples for so many beams with so many samples in all."""
    return Samples(
        np.empty((2, room)), np.empty((2, room), np.int64), np.empty(room, np.int64),
        np.zeros(beams + 1, np.int64), np.empty(beams, np.bool_),
    )  # fmt: skip


@njit(cache=True)
def _detect_echoes(first: int, threshold: Floats, receiver: Receiver, samples: Samples, out: ScanBuffers) -> None:
    """Append the echoes of a block of beams, and the beams that hit something and have none.

    Parameters
    ----------
    first
        First beam of the block.
    threshold
        (K,) minimum power of an echo, per beam [1/m^2].
    """
    # Unpacked once: each access to a record's array costs an atomic reference count.
    value, ids, order, start, blocked = samples
    echo, echo_id, lost_beam, lost_echo = out.echo, out.echo_id, out.lost_beam, out.lost_echo
    found, lost = out.counts[0], out.counts[1]
    for k in range(len(threshold)):
        begin, end = start[k], start[k + 1]
        before, highest, where = found, 0.0, 0.0
        if begin < end:
            sort_by_range(value, order, begin, end)
            found, highest, where = find_echoes(value, order, begin, end, threshold[k], receiver, echo, found)
        for e in range(before, found):
            echo_id[BEAM, e] = first + k
            label_echo(value, ids, order, begin, end, echo, echo_id, e)
        if found == before and (begin < end or blocked[k]):
            lost_beam[lost], lost_echo[RANGE, lost], lost_echo[POWER, lost] = first + k, where, highest
            lost += 1
    out.counts[0], out.counts[1] = found, lost
