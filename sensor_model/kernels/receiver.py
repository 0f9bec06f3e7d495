"""Receivers of the units: from the hits of the rays of a fan to the echoes of its beams."""

import numpy as np

from luxloop.arrays import Floats, Ints
from luxloop.compiled import kernel
from luxloop.sensor_model.kernels.echoes import find_echoes, find_strong_echo, label_echo, sort_by_range
from luxloop.sensor_model.kernels.records import (
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
from luxloop.sensor_model.kernels.samples import gather_samples


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
