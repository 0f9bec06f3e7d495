"""Adaptive trials against an expected variance by enumeration, and on simulated observers with a known curve."""

import numpy as np
import pytest
from scipy.special import expit, logit

from luxloop.scenarios.statistics.adaptive_curve import AdaptiveCurve

SHARES = (0.5, 0.95)


def experiment(rng, middle, width, lapse=0.0, trials=20, sign=-1.0):
    curve = AdaptiveCurve(0.3, 3.6, SHARES, rising=sign > 0)
    for _ in range(trials):
        value = curve.next_value()
        curve.add(value, float(rng.random() < (1 - lapse) * expit(sign * (value - middle) / width)))
    return curve


def test_the_next_trial_has_the_least_expected_variance_of_both_thresholds():
    curve = AdaptiveCurve(0.0, 1.0, SHARES)
    for value, outcome in [(0.5, 1.0), (0.75, 0.0), (0.6, 1.0)]:
        curve.add(value, outcome)
    before, expected = curve._posterior, []
    for value in curve.values:
        variance = 0.0
        for outcome in (0.0, 1.0):
            curve._posterior = before
            likelihood = curve._shares(np.array([value]))[0]
            probability = before @ (likelihood if outcome else 1 - likelihood)
            curve.add(value, outcome)
            after = curve._posterior
            variance += probability * sum(np.cov(curve._values_at(one), aweights=after, ddof=0) for one in SHARES)
        expected.append(variance)
    curve._posterior = before
    assert curve.next_value() == curve.values[int(np.argmin(expected))]


def test_the_value_of_a_share_is_where_the_curve_has_it():
    curve = AdaptiveCurve(0.0, 1.0, SHARES)
    inside = np.flatnonzero((curve._values_at(0.7) > 0.0) & (curve._values_at(0.7) < 1.0))[::7]  # all take seconds
    at = curve._values_at(0.7)[inside]
    shares = curve._shares(at)[np.arange(len(at)), inside]
    assert shares == pytest.approx(np.full(len(at), 0.7))


def test_trials_approach_the_threshold_and_the_interval_shrinks():
    rng = np.random.default_rng(3)
    few, many = (experiment(rng, 2.6, 0.1, trials=count).threshold(0.5) for count in (8, 40))
    assert many.value == pytest.approx(2.6, abs=0.15)
    assert np.diff(many.interval) < 0.6 * np.diff(few.interval)


def test_a_rising_share_has_its_thresholds_in_the_other_order():
    curve = experiment(np.random.default_rng(4), 1.5, 0.1, sign=1.0, trials=30)
    assert curve.threshold(0.5).value == pytest.approx(1.5, abs=0.2)
    assert curve.threshold(0.95).value > curve.threshold(0.5).value


def test_a_trial_of_several_outcomes_counts_by_its_share():
    one, two = AdaptiveCurve(0.0, 1.0, SHARES), AdaptiveCurve(0.0, 1.0, SHARES)
    one.add(0.4, 0.5)
    two.add(0.4, 1.0)
    two.add(0.4, 0.0)
    p = np.clip(one._shares(np.array([0.4]))[0], 1e-9, 1 - 1e-9)
    for curve, likelihood in ((one, np.sqrt(p * (1 - p))), (two, p * (1 - p))):
        assert curve._posterior == pytest.approx(likelihood / likelihood.sum(), rel=1e-6)


@pytest.mark.slow
def test_intervals_of_twenty_trials_hold_both_thresholds():
    """Curves drawn from a range of steepness, with and without lapses of 2 %."""
    rng, held = np.random.default_rng(11), []
    for _ in range(60):
        middle, width = rng.uniform(0.8, 3.2), np.exp(rng.uniform(np.log(0.03), np.log(0.3)))
        lapse = rng.choice([0.0, 0.02])
        truths = [np.clip(middle - width * logit(share / (1 - lapse)), 0.3, 3.6) for share in SHARES]
        held.append(holds(experiment(rng, middle, width, lapse), truths))
    assert np.mean(held, axis=0).min() >= 0.86  # 57 of 60 are expected; fewer than 52 have a probability of 2 %


def holds(curve, truths):
    """Whether the interval of the threshold of each share holds its true value."""
    intervals = [curve.threshold(share).interval for share in SHARES]
    return [low - 1e-9 <= truth <= high + 1e-9 for (low, high), truth in zip(intervals, truths, strict=True)]


@pytest.mark.slow
def test_intervals_hold_the_thresholds_of_a_slow_decline_before_a_sharp_drop():
    """A curve that is in no grid: linear from 1 at 2.0 to 0.7 at the drop, which is at 2.6 to 3.0."""
    rng, held = np.random.default_rng(12), []
    for _ in range(60):
        drop = rng.uniform(2.6, 3.0)
        truths = [drop, 2.0 + (drop - 2.0) * 0.05 / 0.3]
        curve = AdaptiveCurve(0.5, 3.5, SHARES)
        for _ in range(20):
            value = curve.next_value()
            p = np.interp(value, (2.0, drop), (1.0, 0.7)) if value < drop else 0.0
            curve.add(value, float(rng.random() < p))
        held.append(holds(curve, truths))
    assert (
        np.mean(held, axis=0).min() >= 0.82
    )  # 92 % in 200 experiments; fewer than 49 of 60 then have a probability of 1 %
