"""Single rays, as of mirrors, against the slow reference implementation."""

import numpy as np
import pytest
from support.naive_caster import Ray, all_hits, nearest, perturbed, scene_at
from support.sensor_scenes import FOOTPRINT, LUX_RIG, ActorSpec, placed_scene, walls, world

from luxloop.sensor_model.raycaster import GROUND_REFLECTIVITY, Raycaster
from luxloop.sensor_model.returns import GROUND, WALL
from luxloop.sim.world import Kind

RAYS = 400
STREET = (
    ActorSpec(9.0, 3.2, 0.2, velocity=(12.0, -1.0), acceleration=(2.0, 3.0), yaw_rate=-1.1),
    ActorSpec(-8.0, -4.0, 2.5, kind=Kind.VAN, velocity=(-7.0, 0.0), yaw_rate=0.9),
    ActorSpec(3.0, 9.0, 1.2, kind=Kind.BUS, velocity=(0.0, 15.0), yaw_rate=0.5),
    ActorSpec(16.0, -7.0, 2.6, kind=Kind.TRAILER_TRUCK, velocity=(-3.0, 2.0), articulation=0.35),
)
FENCE = walls(((-20, 14), (30, 15)), ((25, -30), (24, 20)), height=2.0, reflectivity=0.7, base=0.3)


def reference(scene, bodies, obstacles, origin, direction, reach):
    """Return range, reflectivity and cosine of the nearest hit within reach; infinite and zeros without one."""
    hit = nearest(all_hits(Ray(tuple(origin), tuple(direction)), scene))
    if hit is None or hit.range >= reach:
        return np.inf, 0.0, 0.0
    if hit.target == GROUND:
        return hit.range, GROUND_REFLECTIVITY, hit.cosine
    surfaces = obstacles.reflectivity if hit.target == WALL else bodies.plane_reflectivity
    return hit.range, surfaces[hit.surface], hit.cosine


@pytest.mark.parametrize("seed", range(3))
def test_single_rays_equal_the_reference_at_their_firing_times(seed):
    """Bodies move and turn: fails if a ray meets one at another time, a hidden side, or a surface beyond its reach."""
    rng = np.random.default_rng(seed)
    beams, bodies, obstacles, context = placed_scene(LUX_RIG, FOOTPRINT, world(*STREET), FENCE)
    caster = Raycaster(beams, FOOTPRINT)
    beam = rng.choice(len(beams), RAYS)
    time = caster.firing_time(context)[beam]
    origin = np.column_stack([rng.uniform(-4.0, 4.0, (RAYS, 2)), rng.uniform(0.4, 1.2, RAYS)])
    direction = np.column_stack([rng.normal(size=(RAYS, 2)), rng.normal(0.0, 0.04, RAYS)])
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    reach = rng.choice([6.0, 15.0, 80.0], RAYS)
    met = caster.cast_mirrored(beam, origin, direction, reach, bodies, obstacles, context)
    found = np.column_stack([met.range, met.reflectivity, met.cosine])
    missed = np.isinf(met.range)
    found[missed, 1:] = 0.0
    assert 40 < missed.sum() < RAYS - 100
    for g in range(RAYS):
        ray = origin[g], direction[g], reach[g]
        expected = reference(scene_at(bodies, obstacles, time[g]), bodies, obstacles, *ray)
        if not np.allclose(found[g], expected, rtol=0, atol=1e-9):
            others = [perturbed(bodies, obstacles, shift) for shift in range(20)]  # rounding decides at edges
            expected = [reference(scene_at(*other, time[g]), *other, *ray) for other in others]
            assert any(np.allclose(found[g], one, rtol=0, atol=1e-6) for one in expected), (g, found[g], expected[0])
