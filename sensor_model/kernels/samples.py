"""Light that returns along the rays of beams: samples of range and power."""

import math

from numba import njit

from sensor_model.arrays import Floats, Ints
from sensor_model.kernels.records import (
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
    Rays,
    Receiver,
    Samples,
    Solids,
    StaticScene,
)
from sensor_model.returns import GROUND, NOTHING, WALL


@njit(cache=True, error_model="numpy")
def gather_samples(
    rays: Rays, low: int, high: int, first: int, rays_wide: int, gain: Floats, receiver: Receiver, bodies: Solids,
    static: StaticScene, samples: Samples,
) -> None:  # fmt: skip
    """Fill the samples of a block of beams of one layer, beam after beam.

    Power is reflectivity x cos(incidence) x gain / range^2 (Lambert), attenuated by the air, in equal shares per ray.

    Parameters
    ----------
    low, high
        The layer has rays [low, high) of each column.
    first
        First azimuth of the block.
    gain
        (K,) sensitivity of each beam.
    """
    # Unpacked once: each access to a record's array costs an atomic reference count.
    column, cos, hit, hit_id, value, ids = rays.column, rays.cos, rays.hit, rays.hit_id, samples.value, samples.id
    targets, inverse_depth, inner_surface = hit_id[TARGET], hit[INVERSE_DEPTH], hit_id[INNER_SURFACE]
    start, blocked = samples.start, samples.blocked
    wall_reflectivity, reflectivity, transmission = static.reflectivity, bodies.reflectivity, bodies.transmission
    ground_reflectivity, extinction, range_min = static.ground_reflectivity, static.extinction, receiver.range_min
    count = 0
    for k in range(len(gain)):
        share, blocked[k] = gain[k] / ((high - low) * rays_wide), False
        for i in range(low, high):
            for m in range((first + k) * rays_wide, (first + k + 1) * rays_wide):
                target = targets[m, i]
                if target == NOTHING:
                    continue
                r = 1.0 / (inverse_depth[m, i] * cos[m, i])
                if r < range_min:
                    blocked[k] = True
                    continue
                if target == GROUND:
                    q, sent = 0, ground_reflectivity * column[2, m] / r
                else:
                    q = hit_id[SURFACE, m, i]
                    sent = (wall_reflectivity[q] if target == WALL else reflectivity[q]) * hit[COSINE, m, i]
                count = _append(target, q, r, sent * share, extinction, value, ids, count)
                behind = inner_surface[m, i]
                if behind != NONE:
                    sent = transmission[q] * reflectivity[behind] * hit[INNER_COSINE, m, i]
                    r = 1.0 / (hit[INNER_INVERSE_DEPTH, m, i] * cos[m, i])
                    count = _append(target, behind, r, sent * share, extinction, value, ids, count)
        start[k + 1] = count


@njit(cache=True, error_model="numpy")
def _append(
    target: int, surface: int, r: float, sent: float, extinction: float, value: Floats, ids: Ints, count: int
) -> int:
    """Append a sample; return the number of samples."""
    air = math.exp(-2.0 * extinction * r) if extinction > 0.0 else 1.0
    value[RANGE, count], value[POWER, count] = r, sent / (r * r) * air
    ids[TARGET, count], ids[SURFACE, count] = target, surface
    return count + 1
