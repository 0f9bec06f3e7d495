"""Corners of convex solids."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from luxloop.sensor_model.bodies.solids import Plane, box
from luxloop.sensor_model.truth import Part

LIMITS = (1.0, 1.2), (-0.3, 0.5), (0.2, 0.9)


def sorted_rows(points):
    return points[np.lexsort(np.round(points, 9).T)]


@pytest.mark.parametrize("depth_m", [0.2, 0.02, 0.012, 0.004, 0.0001])
@pytest.mark.parametrize("shift_m", [(0.0, 0.0, 0.0), (0.7, -0.4, 0.3)])
def test_corners_of_a_box(depth_m, shift_m):
    """Also of a thin one, and of one far from its stated bounding box; thin ones need the linear program."""
    limits = ((1.0, 1.0 + depth_m), *LIMITS[1:])
    solid = box(Part.BODY, *limits)
    wrong = replace(solid, low=tuple(np.add(solid.low, shift_m)), high=tuple(np.add(solid.high, shift_m)))
    expected = np.array(list(product(*limits)))
    found = np.unique(np.round(wrong.corners(), 8), axis=0)
    np.testing.assert_allclose(sorted_rows(found), sorted_rows(expected), atol=1e-7)


@given(st.lists(st.tuples(*[st.floats(-1.0, 1.0)] * 3), min_size=1, max_size=12), st.floats(0.06, 0.5))
def test_planes_without_a_face_do_not_change_corners(normals, distance):
    """All corners fulfil all planes, and the planes that are dropped are fulfilled by all corners of the others."""
    middle = np.array([1.1, 0.1, 0.55])
    planes = []
    for normal in normals:
        length = float(np.linalg.norm(normal))
        if length > 0.1:
            unit = np.array(normal) / length
            planes.append(Plane(tuple(unit.tolist()), float(unit @ middle) + distance, Part.BODY))
    whole = box(Part.BODY, *LIMITS).cut(planes)
    pruned = whole.pruned()
    for plane in whole.planes:
        assert (pruned.corners() @ plane.normal).max() <= plane.offset + 1e-6
    assert set(pruned.planes) <= set(whole.planes)


def test_an_empty_solid_is_refused():
    apart = box(Part.BODY, *LIMITS).cut([Plane((1.0, 0.0, 0.0), 0.9, Part.BODY)])
    with pytest.raises(ValueError, match="no common interior"):
        apart.corners()
