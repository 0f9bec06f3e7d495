"""Outlines of bodies in plan."""

from dataclasses import replace

import numpy as np
import pytest
from support.sensor_scenes import ActorSpec, world
from support.solid_mesh import corners, pieces

from luxloop.sensor_model.bodies.materials import Glass
from luxloop.sensor_model.bodies.scene import BodyFactory
from luxloop.sensor_model.bodies.shapes import SHAPES
from luxloop.sensor_model.truth import Part
from luxloop.sim.world import Kind


def place(*specs, plain=False, seed=3):
    return BodyFactory(mirrors=True, plain=plain, glass=Glass(), seed=seed).place(world(*specs))


def depths(bodies, row, points):
    """Return (E, P) depths of points (P, 2) inside each edge of a body's outline."""
    edges = bodies.outline[bodies.body_outline[row] : bodies.body_outline[row + 1]]
    return edges[:, 2:] - edges[:, :2] @ points.T


@pytest.mark.parametrize("kind", list(Kind))
@pytest.mark.parametrize("factor", [(1.0, 1.0, 1.0), (1.7, 0.6, 1.2)])
def test_outline_is_the_convex_hull_of_all_solids_but_mirrors(kind, factor):
    bodies = place(ActorSpec(0.0, 0.0, kind=kind, size=tuple(np.multiply(SHAPES[kind].size, factor).tolist())))
    outer = [piece for piece in pieces(bodies, 0) if piece.part[0] != Part.MIRROR]
    inside = depths(bodies, 0, np.concatenate([corners(piece.planes) for piece in outer])[:, :2])
    np.testing.assert_allclose(np.linalg.norm(bodies.outline[:, :2], axis=1), 1.0, atol=1e-12)
    assert inside.min() > -1e-9
    assert np.all(np.sum(inside < 1e-9, axis=1) >= 2), "each edge joins two corners"


def test_outline_of_a_box_is_its_rectangle():
    bodies = place(ActorSpec(0.0, 0.0, kind=Kind.CAR, size=(4.0, 2.0, 1.5)), plain=True)
    np.testing.assert_allclose(depths(bodies, 0, np.array([[1.5, 0.9]])).min(), 0.1, atol=1e-12)
    np.testing.assert_allclose(np.sort(bodies.outline[:, 2]), [1.0, 1.0, 2.0, 2.0], atol=1e-12)


def test_outline_has_the_bow_of_the_bumper_and_no_articulation():
    """0.75 m beside the middle, real bumpers recede by 16.5 cm (median), and the ends of a box by nothing."""
    recess = []
    for actor in range(30):
        bodies = place(ActorSpec(0.0, 0.0, kind=Kind.CAR, id=actor + 1))
        end, low, high = np.array([[2.35, 0.75]]), 0.0, 0.5
        for _ in range(30):
            middle = 0.5 * (low + high)
            hit = depths(bodies, 0, end - [middle, 0.0]).min() >= 0.0
            low, high = (low, middle) if hit else (middle, high)
        recess.append(high)
    assert 0.08 < np.median(recess) < 0.22
    truck = ActorSpec(0.0, 0.0, kind=Kind.TRAILER_TRUCK, id=4)
    bent, straight = place(replace(truck, articulation=0.4)), place(truck)
    assert np.array_equal(bent.outline, straight.outline)


def test_each_body_has_its_own_edges():
    specs = [ActorSpec(0.0, 0.0, kind=kind, id=row + 1) for row, kind in enumerate((Kind.CAR, Kind.BUS, Kind.BICYCLE))]
    together, alone = place(*specs), [place(spec) for spec in specs]
    assert together.body_outline.tolist() == np.cumsum([0, *(len(one.outline) for one in alone)]).tolist()
    assert np.array_equal(together.outline, np.concatenate([one.outline for one in alone]))
