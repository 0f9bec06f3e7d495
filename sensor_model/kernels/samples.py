"""Light that returns along the rays of beams: samples of range and power."""

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
    Rays,
    Receiver,
    Samples,
    Solids,
    StaticScene,
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
