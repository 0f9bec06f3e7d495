"""Figures of one vehicle, computed by hand."""

import numpy as np
import pytest
from support.labelled_shapes import ABREAST, l_shape, left, rear, vehicle

from luxloop.scenarios.realism import labelled_fits, vehicle_figures
from luxloop.scenarios.realism.vehicle_figures import density


def figures(seen):
    return vehicle_figures.measure([seen]).iloc[0]


def test_shares_count_points_inside_and_outside_the_faces():
    """Twenty points: fifteen on the rear, one each 0.15, 0.30 and 0.50 m inside, two 0.12 m outside."""
    depth = np.array([0.0] * 15 + [0.15, 0.30, 0.50, -0.12, -0.12])
    along = np.concatenate([np.linspace(-0.6, 0.6, 15), [0.0, 0.1, 0.2, 0.85, 0.88]])
    found = figures(vehicle(rear(depth, along)))
    shares = [found[f"share_{name}"] for name in ("10cm_inside", "20cm_inside", "40cm_inside", "10cm_outside")]
    np.testing.assert_allclose(shares, [3 / 20, 2 / 20, 1 / 20, 2 / 20])


def test_spread_is_the_robust_deviation_of_shallow_points():
    """Depths -6, -4 .. 6 cm about the face and one of 40 cm, which is left out: the MAD is 4 cm."""
    depth = np.array([*np.arange(-0.06, 0.07, 0.02), 0.40])
    seen = vehicle(rear(depth, [0.8] * 8), size=(4.4, 1.8))  # near the corner: the face stays at the label
    assert figures(seen)["std_about_faces_m"] == pytest.approx(1.4826 * 0.04)


def test_heights_and_layers():
    height = np.array([0.3] * 6 + [1.0] * 4)
    found = figures(vehicle(rear(0.0, np.linspace(-0.5, 0.5, 10)), line=[1] * 6 + [257] * 4, height=height))
    assert (found["points"], found["layers"], found["z_median_m"]) == (10, 2, pytest.approx(0.3))
    assert found["share_above_0.9m"] == pytest.approx(0.4)


def test_density_is_points_over_the_length_of_each_line():
    """Lines of 11 points over 2 m and of 31 over 1.5 m; the pair of points is no line."""
    points = np.concatenate(
        [left(0.0, np.linspace(-1, 1, 11)), rear(0.0, np.linspace(-0.75, 0.75, 31)), rear(0.0, [0.0, 0.01])]
    )
    assert density(points, np.repeat([0, 1, 2], [11, 31, 2])) == pytest.approx(np.median([11 / 2, 31 / 1.5]))


def test_bow_is_the_median_of_the_lines_of_its_face():
    along = np.linspace(-0.75, 0.75, 21)
    points = np.concatenate([rear(bow * (along / 0.75) ** 2, along) for bow in (0.08, 0.10, 0.20)])
    found = figures(vehicle(points, line=np.repeat([0, 1, 2], 21)))
    assert found["bow_end_m"] == pytest.approx(0.10)
    assert np.isnan(found["bow_flank_m"])


def test_heading_errors_are_those_of_the_label():
    """The tracker finds the heading of a clean L-shape; a label turned by 3 degrees changes its error by as much."""
    true, turned = (vehicle(l_shape(), lidars=[(-12.0, 12.0)], pose=(12.0, -12.0, 0.0)) for _ in range(2))
    turned.box[2] += np.radians(3.0)
    found = vehicle_figures.measure([true, turned])
    for method in ("closeness", "variance", "tlinkage", "best"):
        error, of_turned = found[f"{method}_error_deg"]
        assert error < 0.25, method
        assert abs(of_turned - 3.0) == pytest.approx(error, abs=1e-9), method
    np.testing.assert_allclose(found["share_on_lines"], 1.0)


def test_heading_errors_are_modulo_a_quarter_turn():
    true, quarter = (vehicle(l_shape(), lidars=[(-12.0, 12.0)], pose=(12.0, -12.0, 0.0)) for _ in range(2))
    quarter.box[2] += np.pi / 2
    for error in labelled_fits.fit([true, quarter]).error_deg.values():
        assert error[0] == pytest.approx(error[1], abs=1e-9)


def test_points_inside_are_not_on_lines():
    inside = [(0.0, 0.0), (0.3, -0.2), (-0.4, 0.1), (0.6, 0.2), (-0.9, -0.3)]
    points = np.concatenate([l_shape(), inside])
    seen = vehicle(points, lidars=[(-12.0, 12.0)], pose=(12.0, -12.0, 0.0))
    assert figures(seen)["share_on_lines"] == pytest.approx(len(l_shape()) / len(points))


def test_view_of_a_vehicle():
    seen = vehicle(l_shape(), lidars=[(10.0 * np.cos(0.5), -10.0 * np.sin(0.5))], pose=(30.0, 4.0, 2.0))
    view = vehicle_figures.keys([seen, vehicle(left(0.0, [0.0]), lidars=[ABREAST])])
    assert view["range_m"].tolist() == pytest.approx([10.0, 20.0])
    assert view["aspect_deg"].tolist() == pytest.approx([np.degrees(0.5), 90.0])
    assert view["front_seen"].tolist() == [True, False]
