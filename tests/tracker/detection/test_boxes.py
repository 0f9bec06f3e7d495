"""Boxes: size gates, nearest corner, covariance; and all stages on degenerate scans."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.shapes import Car, l_shape, rotation, scan_car
from support.stages import fit_points, off_quarter, one_segment

from luxloop.tracker.detection import boxes
from luxloop.tracker.detection.boxes import END_STD_M, NOISE_STD_M, BoxConfig, side_covariance, strays
from luxloop.tracker.detection.segmentation import sort_by_segment
from luxloop.tracker.detection.selection import SelectionConfig
from luxloop.tracker.records import Candidates, Linkage, Segments

SIGMA = 0.02


def block(length, width, center=(20.0, 10.0), heading=0.2):
    """Points on the two sides of a rectangle that face the ego, 0.1 m apart."""
    u, v = np.arange(0.0, length + 1e-9, 0.1), np.arange(0.1, width + 1e-9, 0.1)
    local = np.concatenate([np.stack([u, 0 * u], 1), np.stack([0 * v, v], 1)]) - [length / 2, width / 2]
    return local @ rotation(heading).T + center


def fit_block(*args, **kwargs):
    points = block(*args, **kwargs)
    return fit_points(points, segments=one_segment(len(points))).boxes


@pytest.mark.parametrize("size", [(4.7, 1.8), (16.5, 2.5), (2.2, 0.8), (12.0, 2.5), (0.0, 1.8), (4.7, 0.0)])
def test_vehicle_sizes_are_accepted(size):
    """A single side is accepted, with a tiny other side."""
    built = fit_block(*size)
    assert len(built) == 1
    np.testing.assert_allclose(np.sort(built.size[0]), np.sort(size), atol=0.03)


@pytest.mark.parametrize("size", [(25.0, 0.0), (6.0, 5.0), (0.3, 0.2)], ids=["wall", "hut", "pole"])
def test_other_sizes_are_rejected(size):
    assert len(fit_block(*size)) == 0


@given(st.floats(-30, 30), st.floats(-30, 30), st.floats(0, 1.57), st.floats(0.5, 18), st.floats(0.0, 3.0))
def test_corner_is_the_nearest_of_four(x, y, heading, length, width):
    center, size = np.array([[x, y]]), np.array([[length, width]])
    corner, sign = boxes.nearest_corner(center, np.array([heading]), size)
    every = [center[0] + rotation(heading) @ (0.5 * size[0] * s) for s in itertools.product((1, -1), repeat=2)]
    assert np.linalg.norm(corner[0]) == pytest.approx(min(np.linalg.norm(c) for c in every))
    np.testing.assert_allclose(corner[0] - rotation(heading) @ (0.5 * sign[0] * size[0]), center[0], atol=1e-9)


def test_the_body_lies_behind_the_face_as_seen_from_the_unit():
    """The rear of a lorry beside the ego, 1 m behind its centre, is seen by a unit at its rear bumper, 2.3 m behind."""
    face = (np.array([[-1.0, -3.5]]), np.zeros(1), np.array([[0.0, 2.5]]))
    corner, sign = boxes.nearest_corner(*face, np.array([[-2.3, -0.5]]))
    assert sign.tolist() == [[-1, 1]]  # the lorry extends forwards
    np.testing.assert_allclose(corner, [[-1.0, -2.25]])
    assert boxes.nearest_corner(*face)[1].tolist() == [[1, 1]]


def test_boxes_use_the_position_of_the_unit_that_saw_them():
    points = np.column_stack([np.full(41, -1.0), np.linspace(-4.7, -2.3, 41)])
    for unit_x, along in ((-2.3, 1.0), (2.3, -1.0)):
        built = fit_points(points, segments=one_segment(41), viewpoints=np.full((41, 2), [unit_x, 0.0])).boxes
        into_body = rotation(built.heading[0]) @ (-built.corner_sign[0] * (built.size[0] < 0.5))
        assert np.sign(into_body[0]) == along


def test_corner_of_a_car_ahead_on_the_left():
    """Seen from behind and from the right: its rear right corner, signs (-1, -1)."""
    built = fit_block(4.7, 1.8, center=(20.0, 10.0), heading=0.1)  # at 0, a small error is modulo a quarter turn
    assert built.corner_sign[0].tolist() == [-1, -1]
    np.testing.assert_allclose(built.corner_ego[0], [20.0, 10.0] + rotation(0.1) @ [-2.35, -0.9], atol=0.03)
    assert built.support[0] == len(block(4.7, 1.8))


def test_an_end_is_truncated_where_its_points_are():
    """A side of 4 m along x from (10, 5); low and high ends and both axes must be distinguished."""
    points = np.stack([np.linspace(10.0, 14.0, 41), np.full(41, 5.0)], axis=1)
    for cut_at, ends in ((40, [False, True]), (0, [True, False]), (20, [False, False])):
        built = fit_points(points, segments=one_segment(41), cut_off=np.arange(41) == cut_at).boxes
        axis = int(np.argmax(built.size[0]))
        cut = built.cut[0, axis].tolist()
        along = np.array([np.cos(built.heading[0] + axis * np.pi / 2), np.sin(built.heading[0] + axis * np.pi / 2)])
        assert (cut if along[0] > 0 else cut[::-1]) == ends


@pytest.mark.parametrize(
    ("start", "end", "cut_at", "flat"),
    [
        ((10.0, 8.0), (14.0, 8.0), None, True),  # the ego is far beyond its near end and sees no second side
        ((10.0, 8.0), (14.0, 8.0), 0, False),  # the second side may be hidden, too
        ((-2.0, 8.0), (2.0, 8.0), None, False),  # at normal incidence a second side is not visible
    ],
)
def test_a_single_side_with_a_visible_end_is_flat(start, end, cut_at, flat):
    points = np.linspace(start, end, 41)
    built = fit_points(points, segments=one_segment(41), cut_off=np.arange(41) == cut_at).boxes
    assert built.flat.tolist() == [flat]
    assert not fit_block(4.7, 1.8).flat.any()


@pytest.mark.parametrize(("depth_m", "stray"), [(1.5, False), (4.0, True)])
def test_a_wall_beside_a_corner_is_not_taken_for_a_window(depth_m, stray):
    """Points behind a side are windows; points farther back than a vehicle's width belong to a house."""
    behind = np.array([[0.0, 8.0 + depth_m]])
    points = np.concatenate([np.linspace((-2.0, 8.0), (2.0, 8.0), 41), behind])
    size = np.array([[4.0, 0.05]])
    assert strays(np.ptp(points, axis=0)[None], size, BoxConfig().shorter_max_m).tolist() == [stray]


def covariance(points, corner, heading, noise_std_m=NOISE_STD_M):
    index = np.zeros(len(points), dtype=np.int64)
    return side_covariance(points - corner, index, np.array([heading]), noise_std_m, END_STD_M)[0]


def test_heading_variance_of_one_side_by_hand():
    """Straight line fit: sigma^2 / sum (t - mean t)^2; 21 points 0.2 m apart give sum = 0.04 * 770 = 30.8."""
    points = np.stack([np.linspace(10.0, 14.0, 21), np.full(21, 5.0)], axis=1)
    result = covariance(points, points[0], 0.0, noise_std_m=SIGMA)
    assert result[2, 2] == pytest.approx(SIGMA**2 / 30.8, rel=1e-2)
    assert result[0, 0] == pytest.approx(0.3**2, rel=1e-6), "along the side, its end is all that is known"


def test_covariance_rotates_with_the_box():
    points = np.stack([np.linspace(0.0, 4.0, 21), np.zeros(21)], axis=1)
    turned = covariance(points @ rotation(0.7).T, np.zeros(2), 0.7)
    flat = covariance(points, np.zeros(2), 0.0)
    np.testing.assert_allclose(turned[:2, :2], rotation(0.7) @ flat[:2, :2] @ rotation(0.7).T, atol=1e-12)
    assert turned[2, 2] == pytest.approx(flat[2, 2])


def test_covariance_equals_a_monte_carlo_estimate():
    """Monte Carlo of the least-squares corner and heading of an L; a wrong sign of a row changes the correlations."""
    rng, truth = np.random.default_rng(0), 0.4
    clean = l_shape(truth, step=0.2)
    corner, along, across = np.array([10.0, 5.0]), rotation(truth)[:, 0], rotation(truth)[:, 1]
    u, v = (clean - corner) @ along, (clean - corner) @ across
    on_long = v < 1e-9
    zero, one = np.zeros_like(u), np.ones_like(u)
    rows = np.where(on_long, [zero, one, u], [one, zero, -v]).T
    noise = rng.normal(0.0, SIGMA, (4000, len(clean)))
    estimates = noise @ np.linalg.pinv(rows).T
    turn = np.eye(3)
    turn[:2, :2] = rotation(truth)
    sampled = np.cov((estimates @ turn.T).T)
    result = covariance(clean, corner, truth, noise_std_m=SIGMA)
    scale = np.sqrt(np.outer(np.diag(result), np.diag(result)))
    np.testing.assert_allclose(result / scale, sampled / scale, atol=0.08)


def test_reported_heading_deviation_matches_the_error():
    """On cars with sharp corners the reported deviation is within a factor of two of the error."""
    rng, ratio, choice = np.random.default_rng(4), [], SelectionConfig(variant="alignment")
    for _ in range(150):
        bearing, heading = rng.uniform(-np.pi, np.pi), rng.uniform(0, np.pi)
        center = 15.0 * np.array([np.cos(bearing), np.sin(bearing)])
        points, _ = scan_car(Car(tuple(center), heading, chamfer=0.01, layer_bias=(0.0,) * 4), rng)
        built = fit_points(points, segments=one_segment(len(points)), choice=choice).boxes
        ratio.append(np.deg2rad(off_quarter(built.heading[0], heading)) / np.sqrt(built.covariance[0, 2, 2]))
    assert 0.5 < np.sqrt(np.mean(np.square(ratio))) < 2.0


@pytest.mark.parametrize("variant", ["posterior", "alignment"])
@given(st.integers(0, 10_000), st.integers(2, 60))
def test_covariance_is_positive_definite(variant, seed, count):
    points = np.random.default_rng(seed).normal((15.0, 3.0), (1.5, 0.5), (count, 2))
    choice = SelectionConfig(variant=variant)
    for result in fit_points(points, segments=one_segment(count), choice=choice).boxes.covariance:
        np.testing.assert_allclose(result, result.T, atol=1e-12)
        assert np.linalg.eigvalsh(result).min() > 0.0


def test_boxes_refer_to_their_segments():
    """Rejecting the middle segment must not shift the points of the last one."""
    parts = [block(4.7, 1.8), block(30.0, 0.0, center=(0.0, 30.0), heading=0.0), block(4.5, 1.7, center=(-20.0, 0.0))]
    points = np.concatenate(parts)
    segments = Segments(np.repeat(np.arange(3), [len(part) for part in parts]), 3)
    built = fit_points(points, segments=segments).boxes
    assert built.segment.tolist() == [0, 2]
    assert built.support.tolist() == [len(parts[0]), len(parts[2])]
    assert np.linalg.norm(built.center_ego[1] - [-20.0, 0.0]) < 0.2


@pytest.mark.parametrize(
    ("points", "count"),
    [
        (np.empty((0, 2)), 0),
        (np.array([[5.0, 5.0]]), 0),
        (np.full((40, 2), 5.0), 0),
        (np.stack([np.linspace(5, 8, 40), np.full(40, 4.0)], axis=1), 1),
        (np.stack([np.linspace(5, 8, 100_000), np.full(100_000, 4.0)], axis=1), 1),
    ],
    ids=["empty", "one point", "identical", "collinear", "many"],
)
def test_degenerate_scans_pass_all_stages(points, count):
    built = fit_points(points).boxes
    assert len(built) == count
    assert np.isfinite(built.covariance).all()
    assert built.center_ego.shape == (count, 2)


def test_empty_candidates():
    nothing = Candidates(*(np.empty((0, 4, *shape)) for shape in ((), (2,), (2,), ())), np.empty(0, np.int64))
    points = sort_by_segment(np.empty((0, 2)), Segments(np.empty(0, np.int64), 0))
    built = boxes.build(points, Linkage(np.empty(0, np.int64), np.empty(0)), nothing, BoxConfig())
    assert built.covariance.shape == (0, 3, 3)
    assert built.cut.shape == (0, 2, 2)
    assert built.corner_sign.shape == (0, 2)
