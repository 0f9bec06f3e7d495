"""Fits of bowed bodies: accuracy, reported covariance, invariance and settings."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.bowed_cars import BowedCar, drawn_car, ranged, shifted_lines, visible_points
from support.shapes import rotation
from support.stages import fit_points, off_quarter, one_segment

from luxloop.tracker.detection import body_fit
from luxloop.tracker.detection.segmentation import sort_by_segment
from luxloop.tracker.records import METHODS, Segments

STARTS_DEG = (2.0, -4.0, 15.0, -38.0)
"""Errors of the candidates."""


def fit(clouds, truth, lines=None, starts_deg=STARTS_DEG):
    """Fit each cloud (N, 2) of points as one segment, from candidates beside the true heading."""
    count = [len(points) for points in clouds]
    line = np.zeros(sum(count), np.int64) if lines is None else np.concatenate(lines)
    segments = Segments(np.repeat(np.arange(len(clouds)), count), len(clouds))
    heading = np.reshape(truth, (-1, 1)) + np.deg2rad(starts_deg)
    points = sort_by_segment(np.concatenate(clouds), segments, scan_line=line)
    return body_fit.fit(points, heading, 0.027)


def stds_deg(fitted):
    return np.rad2deg(np.sqrt(fitted.covariance[:, 2, 2]))


def cars_around(count, rng, **noise):
    """Cars at any heading, in every direction of the ego."""
    bearing, distance = rng.uniform(-np.pi, np.pi, count), rng.uniform(5.0, 40.0, count)
    place = np.stack([distance * np.cos(bearing), distance * np.sin(bearing)], axis=1)
    return [BowedCar(tuple(at), heading, **noise) for at, heading in zip(place, rng.uniform(-4, 4, count), strict=True)]


# --- accuracy -------------------------------------------------------------------------------


def test_headings_without_noise_are_exact():
    """With the bow of the prior; a flank or end alone is symmetric about a middle that the fit does not know."""
    rng = np.random.default_rng(0)
    cars = cars_around(150, rng)
    seen = [visible_points(car, 40, rng) for car in cars]
    fitted = fit([points for points, _ in seen], [car.heading for car in cars])
    error = np.abs(off_quarter(fitted.heading, [car.heading for car in cars]))
    both = np.array([np.ptp(side) == 1 for _, side in seen])
    assert both.sum() > 100
    assert error[both].max() < 0.01
    assert np.all(error[~both] < 0.5 * stds_deg(fitted)[~both])


def test_noisy_headings_are_within_three_reported_deviations():
    rng = np.random.default_rng(1)
    cars = cars_around(150, rng, range_std=0.027, scatter=0.02, inside_share=0.03)
    clouds = [visible_points(car, 40, rng)[0] for car in cars]
    lines = [rng.integers(0, 4, len(points)) for points in clouds]
    fitted = fit(clouds, [car.heading for car in cars], lines)
    error = np.abs(off_quarter(fitted.heading, [car.heading for car in cars]))
    assert np.all(error < 3.0 * stds_deg(fitted))
    assert error.mean() < 0.4


def test_ninety_percent_intervals_cover_bodies_of_the_prior():
    """Bows, depths of scan lines, noise and points inside are those of the settings."""
    rng = np.random.default_rng(2)
    cars, clouds, lines = [drawn_car(rng) for _ in range(600)], [], []
    for car in cars:
        points, side = visible_points(car, rng.integers(10, 60), rng)
        lines.append(rng.integers(0, 4, len(points)))
        clouds.append(shifted_lines(car, points, lines[-1], side, rng))
    fitted = fit(clouds, [car.heading for car in cars], lines)
    error = np.abs(off_quarter(fitted.heading, [car.heading for car in cars]))
    assert 0.85 < np.mean(error < 1.645 * stds_deg(fitted)) < 0.97


def rear(rng, place, depth, bend):
    """Rear of a car seen from straight behind: points (N, 2) and the heading."""
    bearing, distance = rng.uniform(-np.pi, np.pi), rng.uniform(8.0, 25.0)
    heading = bearing + np.deg2rad(rng.uniform(-3.0, 3.0))
    local = np.stack([bend * place**2 + depth - 2.2, place], axis=1)
    center = distance * np.array([np.cos(bearing), np.sin(bearing)])
    return ranged(local @ rotation(heading).T + center, 0.027, rng), heading


def test_a_bowed_rear_misleads_the_criteria_and_not_the_body():
    """Real cars: 16.5 cm over 0.75 m to either side. The least area of a symmetric bow is at its heading: a tie."""
    rng, error = np.random.default_rng(3), []
    for _ in range(200):
        place = np.linspace(-0.75, 0.75, 60) + rng.uniform(-0.01, 0.01)
        points, heading = rear(rng, place, 0.0, 0.165 / 0.75**2)
        candidates = fit_points(points, segments=one_segment(60)).candidates
        error.append(np.abs(off_quarter(candidates.heading[0], heading)))
        assert METHODS[candidates.best[0]] == "refined"
    by_method = dict(zip(METHODS, np.transpose(error), strict=True))
    best = by_method.pop("refined")
    loss = best - by_method.pop("area")
    assert loss.mean() < 3.0 * loss.std() / np.sqrt(len(loss))
    assert all(best.mean() < 0.5 * other.mean() for other in by_method.values())


def test_scan_lines_apart_do_not_turn_the_heading():
    """Glass 0.3 m behind the bumper; obstacles hide one end of each: as one scan line they seem to lean by 15 degrees.

    The offsets have a prior of 0.1 m, which leaves a seventh of it.
    """
    rng, place, line = np.random.default_rng(4), np.r_[-0.85:0.3:20j, -0.3:0.85:20j], np.repeat([0, 1], 20)
    drawn = [rear(rng, place, 0.3 * line, 0.22) for _ in range(200)]
    clouds, truth = [points for points, _ in drawn], np.array([heading for _, heading in drawn])
    apart, together = fit(clouds, truth, [line] * 200), fit(clouds, truth)
    assert np.mean(np.abs(off_quarter(apart.heading, truth)) < 1.645 * stds_deg(apart)) > 0.85
    assert abs(np.mean(off_quarter(apart.heading, truth))) < stds_deg(apart).mean()
    assert abs(np.mean(off_quarter(together.heading, truth))) > 4 * abs(np.mean(off_quarter(apart.heading, truth)))


def test_an_arc_without_faces_has_a_wide_interval():
    """A greenhouse close by, a circle of 0.9 m radius: every heading fits it about as well."""
    rng, clouds = np.random.default_rng(5), []
    for _ in range(100):
        bearing = rng.uniform(-np.pi, np.pi)
        turn = bearing + np.linspace(-1.2, 1.2, 30)
        center = rng.uniform(3.0, 12.0) * np.array([np.cos(bearing), np.sin(bearing)])
        clouds.append(ranged(center - 0.9 * np.stack([np.cos(turn), np.sin(turn)], axis=1), 0.027, rng))
    std = stds_deg(fit(clouds, rng.uniform(0.0, 1.5, 100)))
    assert np.median(std) > 8.0
    assert np.mean(std > 5.0) > 0.7
    assert std.min() > 3.0


# --- invariance -----------------------------------------------------------------------------


def one_car(seed, per_face=22):
    """Points of a car of the prior, their scan lines and its heading."""
    rng = np.random.default_rng(seed)
    car = drawn_car(rng)
    points, _ = visible_points(car, per_face, rng)
    return points, rng.integers(0, 4, len(points)), car.heading


@settings(max_examples=20)
@given(st.integers(0, 10_000), st.sampled_from([15, 80]))
def test_the_order_of_points_has_no_effect(seed, per_face):
    points, line, heading = one_car(seed, per_face)
    order = np.random.default_rng(seed).permutation(len(points))
    fitted, other = fit([points], heading, [line]), fit([points[order]], heading, [line[order]])
    assert off_quarter(other.heading, fitted.heading) == pytest.approx(0.0, abs=1e-7)
    np.testing.assert_allclose(other.covariance, fitted.covariance, rtol=1e-6, atol=1e-12)


@settings(max_examples=20)
@given(st.integers(0, 10_000), st.sampled_from([np.pi / 2, np.pi, 1.0, -0.3]))
def test_heading_and_covariance_turn_with_the_scene(seed, angle):
    """With up to 48 points; of more points, the bearings at which the sample begins do not turn."""
    points, line, heading = one_car(seed)
    turn = np.eye(3)
    turn[:2, :2] = rotation(angle)
    fitted, turned = fit([points], heading, [line]), fit([points @ rotation(angle).T], heading + angle, [line])
    assert off_quarter(turned.heading, fitted.heading + angle) == pytest.approx(0.0, abs=1e-6)
    np.testing.assert_allclose(turned.covariance[0], turn @ fitted.covariance[0] @ turn.T, rtol=1e-5, atol=1e-9)


def test_a_mirror_image_has_the_mirrored_heading():
    """Of two results that are about equal the bins of the alignment choose one, and bins begin at the lower end."""
    flip, turn = np.diag([1.0, -1.0, -1.0]), []
    for seed in range(60):
        points, line, heading = one_car(seed)
        fitted = fit([points], heading, [line])
        mirrored = fit([points * [1.0, -1.0]], -heading, [line], starts_deg=-np.array(STARTS_DEG))
        expected = flip @ fitted.covariance[0] @ flip
        size = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
        turn.append(abs(off_quarter(mirrored.heading[0], -fitted.heading[0])))
        np.testing.assert_allclose(mirrored.covariance[0] / size, expected / size, atol=0.05)
    assert np.median(turn) < 1e-6
    assert np.max(turn) < 0.1


def test_segments_are_independent():
    drawn = [one_car(seed) for seed in range(4)]
    points, lines, heading = zip(*drawn, strict=True)
    together = fit(points, heading, lines)
    for k in range(4):
        single = fit([points[k]], heading[k], [lines[k]])
        assert single.heading[0] == together.heading[k]
        np.testing.assert_array_equal(single.covariance[0], together.covariance[k])


# --- covariance of the place ----------------------------------------------------------------


def test_a_side_without_points_leaves_its_place_unknown():
    """A flank alone, 5 m to the left: its depth is known to centimetres, the place along it is not."""
    rng = np.random.default_rng(6)
    points, _ = visible_points(BowedCar((0.0, 5.0), 0.0, range_std=0.027, scatter=0.02), 40, rng)
    x, y = np.sqrt(np.diag(fit([points], 0.0).covariance[0])[:2])
    assert y < 0.15
    assert x > 0.3


def test_the_heading_has_the_asymmetry_of_bodies_at_least():
    points, _ = visible_points(BowedCar(), 5000, np.random.default_rng(7))
    assert np.sqrt(fit([points], 0.0).covariance[0, 2, 2]) > 0.005


# --- inputs ---------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [1, 2, 3, 200])
def test_points_at_one_place_have_a_finite_result(count):
    fitted = fit([np.full((count, 2), 7.0)], 0.3)
    assert np.isfinite(fitted.heading).all()
    assert np.linalg.eigvalsh(fitted.covariance[0]).min() > 0.0


def test_points_are_sorted_by_segment_then_by_scan_line():
    rng = np.random.default_rng(4)
    line, segment = rng.integers(0, 7, 200), np.sort(rng.integers(0, 5, 200))
    np.testing.assert_array_equal(body_fit.by_line(line, segment), np.lexsort((line, segment)))
    assert len(body_fit.by_line(line[:0], segment[:0])) == 0
