"""Kernels of tracking against their reference implementations, on random tracks and boxes."""

import dataclasses

import numpy as np
import pytest
from support import naive_filters, naive_hypotheses, naive_sizes
from support.filter_bank import Filters
from support.one_track import DT

from luxloop.tracker import vehicle_classes
from luxloop.tracker.geometry import rotated_covariance, variance_along
from luxloop.tracker.kernels import placed
from luxloop.tracker.records import MODEL_NAMES, MODELS, PREDICTION_S
from luxloop.tracker.tracking import corner, mma, output, traffic_flow, vehicle_size
from luxloop.tracker.tracking import filters as filters_module
from luxloop.tracker.tracking.association import AssociationConfig, score
from luxloop.tracker.tracking.existence import ALONG, QUANTILES, predicted_places
from luxloop.tracker.tracking.filters import FilterConfig, motion
from luxloop.tracker.tracking.hypotheses import HypothesisConfig, Predictions, hypothesise
from luxloop.tracker.tracking.mma import MmaConfig, changes
from luxloop.tracker.tracking.observations import Observations, turned_covariances
from luxloop.tracker.vehicle_classes import GRID_M, side_probabilities

TRACKS, BOXES = 7, 9
FLOOR, TAIL_DOF = 1e-9, 4.0


def covariances(rng, *shape, scale=1.0):
    """Positive definite matrices of a shape (..., n, n)."""
    root = rng.normal(0.0, scale, shape)
    return root @ root.swapaxes(-1, -2) + 0.01 * scale**2 * np.eye(shape[-1])


def random_banks(rng):
    """Filters and probabilities of banks of the standard models; some vehicles stand."""
    mean = rng.normal(0.0, 5.0, (TRACKS, 3, 6)) * rng.choice([0.0, 1.0], (TRACKS, 1, 1), p=(0.2, 0.8))
    probability = rng.dirichlet(np.ones(3), TRACKS)
    return Filters(mean, covariances(rng, TRACKS, 3, 6, 6)), probability


def random_scene(rng):
    """Predictions of tracks, and boxes near their places: turned, truncated, longer and shorter."""
    size = rng.uniform((3.0, 1.5), (8.0, 2.5), (TRACKS, 2))
    heading, center = rng.uniform(-3.0, 3.0, TRACKS), rng.uniform(-20.0, 20.0, (TRACKS, 2))
    position = center[:, None] + rng.normal(0.0, 1.0, (TRACKS, 3, 2))
    tracks = Predictions(
        position=position,
        velocity=rng.normal(0.0, 5.0, (TRACKS, 3, 2)),
        covariance=covariances(rng, TRACKS, 3, 2, 2),
        probability=rng.dirichlet(np.ones(3), TRACKS),
        heading=heading,
        heading_variance=rng.uniform(1e-4, 1e-2, TRACKS),
        size=size,
        known_size=size * rng.choice([0.3, 0.95, 1.0], (TRACKS, 2)),
        whole=rng.choice([False, True], (TRACKS, 2)),
        corner_sign=rng.choice([-1, 1], (TRACKS, 2)),
    )
    of = rng.integers(0, TRACKS, BOXES)
    seen = Observations(
        center=center[of] + rng.normal(0.0, 1.5, (BOXES, 2)),
        heading=heading[of] + rng.integers(-3, 4, BOXES) * np.pi / 2 + rng.normal(0.0, 0.1, BOXES),
        size=rng.uniform(0.1, 6.0, (BOXES, 2)),
        corner_sign=rng.choice([-1, 1], (BOXES, 2)),
        covariance=covariances(rng, BOXES, 3, 3, scale=0.1),
        cut=rng.choice([False, True], (BOXES, 4)),
        flat=np.zeros(BOXES, dtype=np.bool_),
        time_offset=rng.uniform(-0.04, 0.04, BOXES),
        sensor=rng.normal(0.0, 1.0, (BOXES, 2)),
    )
    return tracks, seen


@pytest.fixture(params=range(4))
def rng(request):
    return np.random.default_rng(request.param)


# --- filters


def test_filters_move_on_as_the_reference(rng):
    filters, step = random_banks(rng)[0], motion(DT, FilterConfig()).models
    expected = naive_filters.predict(filters.mean, filters.covariance, step.transition, step.noise)
    filters.predict(step)
    np.testing.assert_allclose(filters.mean, expected[0], rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(filters.covariance, expected[1], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("measured", [1, 2])
def test_filters_are_corrected_as_by_the_reference(rng, measured):
    mean, covariance = rng.normal(size=(8, 6)), covariances(rng, 8, 6, 6)
    residual, noise = rng.normal(size=(8, measured)), covariances(rng, 4, measured, measured)
    found = filters_module.correct_rows(mean, covariance, residual, noise)
    expected = naive_filters.correct(mean, covariance, residual, np.repeat(noise, 2, axis=0))
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("models", [MODELS, MODELS[1:], ("ca", "cv", "stationary")])
def test_changes_of_the_mode_equal_the_reference(rng, models):
    filters, config = random_banks(rng)[0], MmaConfig()
    few = Filters(filters.mean[:, : len(models)].copy(), filters.covariance[:, : len(models)].copy())
    expected = naive_filters.transitions(few, DT, config, models)
    found = mma.transitions(few.mean, few.covariance, changes(DT, config, models))
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-15)


def test_mixing_and_model_probabilities_equal_the_reference(rng):
    (filters, probability), evidence = random_banks(rng), rng.normal(0.0, 20.0, (TRACKS, 3))
    chain = naive_filters.transitions(filters, DT, MmaConfig())
    mean, covariance, prior = mma.mix(filters.mean, filters.covariance, probability, chain)
    expected = naive_filters.mix(filters, probability, chain)
    np.testing.assert_allclose(mean, expected[0].mean, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(covariance, expected[0].covariance, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(prior, expected[1], rtol=1e-12)
    np.testing.assert_allclose(
        mma.update(probability, evidence, 0.02), naive_filters.update(probability, evidence, 0.02), rtol=1e-12
    )


def test_scores_equal_the_reference(rng):
    filters, residual, noise = random_banks(rng)[0], rng.normal(size=(TRACKS, 3, 2)), covariances(rng, TRACKS, 2, 2)
    found = mma.score(filters.covariance, residual, noise, TAIL_DOF)
    for one, other in zip(found, naive_filters.score(filters, residual, noise, TAIL_DOF), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9)


def test_banks_move_on_by_mixing_and_prediction(rng):
    (filters, probability), step = random_banks(rng), motion(DT, FilterConfig())
    states = filters.mean, filters.covariance, probability
    steps = step.models.transition, step.models.noise
    found = mma.predict_banks(*states, *steps, changes(DT, MmaConfig(), MODELS))
    mixed, prior = naive_filters.mix(filters, probability, naive_filters.transitions(filters, DT, MmaConfig()))
    expected = *naive_filters.predict(mixed.mean, mixed.covariance, *steps), prior
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-12)


def test_banks_are_updated_by_score_and_correction(rng):
    filters, probability = random_banks(rng)
    residual, noise = rng.normal(size=(TRACKS, 3, 2)), covariances(rng, TRACKS, 2, 2)
    before = filters.covariance.copy()
    states = filters.mean, filters.covariance, probability
    found = mma.correct_banks(*states, residual, noise, TAIL_DOF, FLOOR)
    np.testing.assert_array_equal(filters.covariance, before)
    evidence, scale = naive_filters.score(filters, residual, noise, TAIL_DOF)
    used = scale[:, None, None] * noise
    corrected = naive_filters.correct(filters.mean, filters.covariance, residual, used[:, None])
    expected = *corrected, naive_filters.update(probability, evidence, FLOOR), used
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-12)


def test_independent_filters_are_corrected_by_the_measured_corner(rng):
    filters, measured = random_banks(rng)[0], rng.normal(size=(TRACKS, 2))
    noise, residual = covariances(rng, TRACKS, 2, 2), measured[:, None] - filters.mean[..., :2]
    *found, nis = mma.correct_independent(filters.mean, filters.covariance, measured, noise)
    innovation = filters.covariance[..., :2, :2] + noise[:, None]
    expected = np.einsum("tmi,tmij,tmj->tm", residual, np.linalg.inv(innovation), residual)
    np.testing.assert_allclose(nis, expected, rtol=1e-9)
    corrected = naive_filters.correct(filters.mean, filters.covariance, residual, noise[:, None])
    for one, other in zip(found, corrected, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-12)


# --- hypotheses


def test_boxes_are_turned_and_moved_by_the_pose_of_the_ego(rng):
    pose, points, covariance = np.array([3.0, -2.0, 0.7]), rng.normal(size=(BOXES, 2)), covariances(rng, BOXES, 3, 3)
    cos, sin = np.cos(0.7), np.sin(0.7)
    turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(placed(points, pose), points @ turn[:2, :2].T + pose[:2], atol=1e-12)
    expected = turn @ covariance @ turn.T + np.diag([0.1, 0.1, 0.2])
    np.testing.assert_allclose(turned_covariances(covariance, 0.7, (0.1, 0.2)), expected, atol=1e-12)


def test_hypotheses_and_their_scores_equal_the_reference(rng):
    (tracks, seen), config = random_scene(rng), HypothesisConfig()
    found, expected = hypothesise(tracks, seen, config), naive_hypotheses.hypothesise(tracks, seen, config)
    for field in dataclasses.fields(found):
        one, other = getattr(found, field.name), getattr(expected, field.name)
        np.testing.assert_allclose(one, other, atol=1e-12, err_msg=field.name)
    assert 0 < found.end_visible.sum() < found.end_visible.size
    assert 0 < (found.corner_sign != tracks.corner_sign[:, None]).sum() < found.corner_sign.size
    coasting = rng.choice([False, True], TRACKS)
    for gate in (AssociationConfig(), AssociationConfig(shape_cost_max=0.0), AssociationConfig(gate_chi2=200.0)):
        cost, admissible = score(tracks, found, seen, gate, coasting)
        expected_cost, expected_mask = naive_hypotheses.score(tracks, expected, seen, gate, coasting)
        np.testing.assert_allclose(cost, expected_cost, rtol=1e-9)
        np.testing.assert_array_equal(admissible, expected_mask)
        assert 0 < admissible.sum() < admissible.size


# --- corner, flow, prediction


def test_corner_errors_are_rotated_variances(rng):
    variance, exact = rng.uniform(0.0, 1.0, (TRACKS, 2)), rng.choice([False, True], (TRACKS, 2))
    covariance, heading = covariances(rng, TRACKS, 2, 2, scale=0.7), rng.uniform(-3.0, 3.0, TRACKS)
    along = np.array([variance_along(one, angle) for one, angle in zip(covariance, heading.tolist(), strict=True)])

    def rotated(variances):
        return [rotated_covariance(one, angle) for one, angle in zip(variances, heading.tolist(), strict=True)]

    np.testing.assert_allclose(corner.rotated(variance, heading), rotated(variance), atol=1e-14)
    removed = np.where(exact, np.maximum(variance - along, 0.0), 0.0)
    np.testing.assert_allclose(corner.released(variance, exact, covariance, heading), rotated(removed), atol=1e-14)
    observed = corner.observe(variance, exact, covariance, heading, 0.3)
    np.testing.assert_allclose(observed, np.where(exact, along, np.maximum(variance, 0.3)), atol=1e-14)


def test_agreement_of_neighbours_equals_the_weighted_sums(rng):
    position, direction, ids = rng.normal(0.0, 9.0, (6, 2)), rng.uniform(-3.0, 3.0, 6), np.arange(6)
    place, heading, others = rng.normal(size=2), 0.4, ids != 2
    offset = position[others] - place
    weight = np.exp(-np.hypot(*offset.T) / 15.0)
    expected = weight.sum(), weight @ np.cos(2.0 * (direction[others] - heading))
    found = traffic_flow.axis_agreement(position, direction, ids, 2, place, heading, 15.0)
    assert found == pytest.approx(expected)
    forward = np.array([np.cos(heading), np.sin(heading)])
    along, across = offset @ forward, offset @ np.array([-forward[1], forward[0]])
    known = np.arange(6) != 4
    weight = known[others] * np.exp(-np.abs(along) / 15.0 - 0.5 * (across / 1.75) ** 2)
    expected = weight.sum(), weight @ np.cos(direction[others] - heading)
    found = traffic_flow.front_agreement(position, direction, known, ids, 2, place, heading, 15.0, 1.75)
    assert found == pytest.approx(expected)


def test_predictions_of_a_bank_are_the_weighted_mean_of_its_models(rng):
    independent, bank = rng.normal(0.0, 5.0, (2, TRACKS, len(MODEL_NAMES), 6))
    weight, time = rng.dirichlet(np.ones(len(MODEL_NAMES)), TRACKS), rng.uniform(1.0, 5.0, TRACKS)
    yaw_rate, direction = rng.normal(0.0, 0.3, TRACKS), np.exp(1j * rng.uniform(-3.0, 3.0, TRACKS))
    models = np.arange(len(MODEL_NAMES))
    found = output.predicted_corners(independent, bank, weight, time, yaw_rate, direction, models)
    for t in range(TRACKS):
        for h, ahead in enumerate(PREDICTION_S):
            inputs, share = (yaw_rate[t], direction[t], ahead), output.lasting(ahead, time[t])
            alone = [output.position(m, independent[t, m], 1.0, *inputs) for m in models]
            mixed = sum(weight[t, m] * output.position(m, bank[t, m], share, *inputs) for m in models)
            places = np.array([*alone, mixed])
            np.testing.assert_allclose(found[t, :, h], np.column_stack([places.real, places.imag]), atol=1e-12)


def test_predicted_places_have_the_directions_of_the_covariance(rng):
    center, heading, length = rng.normal(size=(3, 2)), rng.uniform(-3.0, 3.0, 3), rng.uniform(2.0, 9.0, 3)
    covariance = covariances(rng, 3, 2, 2)
    found = predicted_places(center, heading, length, covariance)
    for t in range(3):
        value, vector = np.linalg.eigh(covariance[t])
        spread = np.stack(np.meshgrid(QUANTILES, QUANTILES), axis=-1).reshape(-1, 2) * np.sqrt(value)
        along = np.outer(length[t] * np.array(ALONG), [np.cos(heading[t]), np.sin(heading[t])])
        expected = (center[t] + spread @ vector.T)[:, None] + along
        for a in range(len(ALONG)):
            one, other = (places[np.lexsort(places.round(9).T)] for places in (found[t, :, a], expected[:, a]))
            np.testing.assert_allclose(one, other, atol=1e-9)


# --- sides and sizes


def test_log_odds_of_sides_equal_the_reference(rng):
    for _ in range(50):
        size, whole = rng.exponential(3.0, 2), rng.choice([False, True], 2)
        for truncated in (0.0, 0.3, 1.0):
            found = vehicle_classes.length_log_odds(size, whole, 0.6, truncated)
            assert found == pytest.approx(naive_sizes.length_log_odds(size, whole, 0.6, truncated), rel=1e-13)
            found = vehicle_classes.class_log_odds(size, whole, truncated)
            assert found == pytest.approx(naive_sizes.class_log_odds(size, whole, truncated), rel=1e-13, abs=1e-13)


def test_sizes_equal_the_reference_after_any_views(rng):
    hidden = np.array([0.27, 0.15])
    likelihoods, views = np.zeros((2, 2, len(GRID_M))), np.zeros((2, 2), dtype=np.int64)
    for _ in range(20):
        observed, whole = rng.uniform(0.1, (6.0, 3.0)), rng.choice([False, True], 2)
        found = vehicle_size.add_view_and_estimate(*likelihoods, views, observed, whole, hidden, side_probabilities())
        expected = naive_sizes.estimate(likelihoods.sum(axis=0), *side_probabilities())
        np.testing.assert_allclose(found, expected, rtol=1e-9)
    assert (views[0] >= views[1]).all()
    assert (views[0] > 10).all()
