"""What comes back to the beams of a fan, and what their unit makes of it."""

import math

import numpy as np
from numba import njit

from sensor_model.arrays import Floats, Ints
from sensor_model.kernels.echoes import BEAM, POWER, RANGE, SURFACE, TARGET, find_echoes, name_echo, sort_by_range
from sensor_model.kernels.rays import NONE
from sensor_model.kernels.records import Beams, Rays, Solids, StaticScene, Units
from sensor_model.returns import GROUND, NOTHING, WALL


@njit(cache=True)
def listen(
    u: int, beam: Ints, beams: Beams, units: Units, bodies: Solids, around: StaticScene, turns: int, rays: Rays,
    echo: Floats, echo_id: Ints, found: int, lost_beam: Ints, lost_echo: Floats, lost: int,
) -> tuple[int, int]:  # fmt: skip
    """Turn what comes back to each beam of a fan of unit u into echoes, or count the beam as lost.

    Parameters
    ----------
    beam
        First beam of each layer.
    echo, echo_id, lost_beam, lost_echo
        Out, after the first `found` and `lost`, as in `cast_rig`.

    Returns
    -------
    How many there are now of both.
    """
    # Out of their records once: each time costs an atomic reference count.
    column, cos, nearness, target, surface, cosine = (
        rays.column, rays.cos, rays.nearness, rays.target, rays.surface, rays.cosine,
    )  # fmt: skip
    inner_surface, inner_nearness, inner_cosine = rays.inner_surface, rays.inner_nearness, rays.inner_cosine
    wall_reflectivity, reflectivity, transmission = around.reflectivity, bodies.reflectivity, bodies.transmission
    ground_reflectivity, extinction, gain, threshold = (
        around.ground_reflectivity, around.extinction, beams.gain, beams.threshold,
    )  # fmt: skip
    columns, n = cos.shape
    rises = n // len(beam)
    range_min, pulse_length, pulse_growth = units.range_min[u], units.pulse_length[u], units.pulse_growth[u]
    separation, most = units.echo_separation[u], units.echoes_max[u]
    room = 2 * rises * turns
    sample, sample_id, order = np.empty((2, room)), np.empty((2, room), np.int64), np.empty(room, np.int64)
    for layer in range(len(beam)):
        for k in range(columns // turns):
            b = beam[layer] + k
            samples, blocked = _gather(
                column, cos, nearness, target, surface, cosine, inner_surface, inner_nearness, inner_cosine,
                layer * rises, (layer + 1) * rises, k * turns, (k + 1) * turns,
                ground_reflectivity, wall_reflectivity, reflectivity, transmission,
                gain[b], range_min, extinction, sample, sample_id,
            )  # fmt: skip
            if samples == 0:
                if blocked:
                    lost_beam[lost], lost_echo[RANGE, lost], lost_echo[POWER, lost] = b, 0.0, 0.0
                    lost += 1
                continue
            sort_by_range(sample, order, samples)
            before = found
            found, highest, where = find_echoes(
                sample, order, samples, threshold[b], pulse_length, pulse_growth, separation, most, echo, found
            )
            for e in range(before, found):
                echo_id[BEAM, e] = b
                name_echo(sample, sample_id, order, samples, echo, echo_id, e)
            if found == before:
                lost_beam[lost], lost_echo[RANGE, lost], lost_echo[POWER, lost] = b, where, highest
                lost += 1
    return found, lost


@njit(cache=True, error_model="numpy")
def _gather(
    column: Floats, cos: Floats, nearness: Floats, target: Ints, surface: Ints, cosine: Floats, inner_surface: Ints,
    inner_nearness: Floats, inner_cosine: Floats, low: int, high: int, first: int, end: int,
    ground_reflectivity: float, wall_reflectivity: Floats, reflectivity: Floats, transmission: Floats,
    gain: float, range_min: float, extinction: float, sample: Floats, sample_id: Ints,
) -> tuple[int, bool]:  # fmt: skip
    """Fill the samples of a beam, rays [low, high) of columns [first, end).

    Power is reflectivity x cos(incidence) x gain / range^2 (Lambert), weakened by the air, in equal parts for the rays.

    Returns
    -------
    How many there are, and whether a ray met something nearer than the unit measures, from which nothing returns.
    """
    share = gain / ((high - low) * (end - first))
    count, blocked = 0, False
    for i in range(low, high):
        for m in range(first, end):
            met = target[m, i]
            if met == NOTHING:
                continue
            r = 1.0 / (nearness[m, i] * cos[m, i])
            if r < range_min:
                blocked = True
                continue
            if met == GROUND:
                q, sent = 0, ground_reflectivity * column[2, m] / r
            else:
                q = surface[m, i]
                sent = (wall_reflectivity[q] if met == WALL else reflectivity[q]) * cosine[m, i]
            count = _add(met, q, r, sent * share, extinction, sample, sample_id, count)
            behind = inner_surface[m, i]
            if behind != NONE:
                sent = transmission[q] * reflectivity[behind] * inner_cosine[m, i]
                r = 1.0 / (inner_nearness[m, i] * cos[m, i])
                count = _add(met, behind, r, sent * share, extinction, sample, sample_id, count)
    return count, blocked


@njit(cache=True, error_model="numpy")
def _add(
    target: int, surface: int, r: float, sent: float, extinction: float, sample: Floats, sample_id: Ints, count: int
) -> int:
    """Append a sample; return how many there are."""
    air = math.exp(-2.0 * extinction * r) if extinction > 0.0 else 1.0
    sample[RANGE, count], sample[POWER, count] = r, sent / (r * r) * air
    sample_id[TARGET, count], sample_id[SURFACE, count] = target, surface
    return count + 1
