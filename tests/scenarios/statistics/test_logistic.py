"""Firth's logistic regression against a general optimiser, and the coverage of its resampled intervals."""

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.special import expit

from luxloop.scenarios.statistics.logistic import fit, percentile_interval, resampled


def by_optimiser(x, y, weight=None):
    """Maximise the penalised likelihood directly, without derivatives."""
    weight = np.ones(len(x)) if weight is None else weight
    design = np.column_stack([np.ones_like(x), x])

    def loss(beta):
        p = np.clip(expit(design @ beta), 1e-12, 1 - 1e-12)
        information = design.T @ (design * (weight * p * (1 - p))[:, None])
        return -np.sum(weight * np.where(y, np.log(p), np.log1p(-p))) - 0.5 * np.linalg.slogdet(information)[1]

    options = {"xatol": 1e-9, "fatol": 1e-12, "maxiter": 20_000, "maxfev": 20_000}
    return minimize(loss, np.zeros(2), method="Nelder-Mead", options=options).x


def sample(rng, count=60):
    x = rng.uniform(0.0, 4.0, count)
    return x, rng.random(count) < expit(3.0 * (2.0 - x))


@pytest.mark.parametrize("seed", range(3))
def test_the_fit_is_the_maximum_of_the_penalised_likelihood(seed):
    x, y = sample(np.random.default_rng(seed))
    found = fit(x, y)
    assert (found.intercept[0], found.slope[0]) == pytest.approx(by_optimiser(x, y), rel=1e-4)
    assert found.value_at(0.5)[0] == pytest.approx(-found.intercept[0] / found.slope[0])
    assert found.share(found.value_at(0.95))[0, 0] == pytest.approx(0.95)


def test_separated_outcomes_have_a_finite_fit():
    x = np.array([0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0])
    y = x < 2.2
    found = fit(x, y)
    assert (found.intercept[0], found.slope[0]) == pytest.approx(by_optimiser(x, y), rel=1e-3)
    assert found.value_at(0.5)[0] == pytest.approx(2.25, abs=0.01)  # the sample is symmetric about 2.25


def test_weights_are_repetitions_and_every_row_is_a_fit_of_its_own():
    rng = np.random.default_rng(5)
    x, y = sample(rng, 30)
    counts = rng.integers(0, 4, (2, 30))
    together = fit(x, y, counts.astype(float))
    for row, count in enumerate(counts):
        alone = fit(np.repeat(x, count), np.repeat(y, count))
        assert together.slope[row] == pytest.approx(alone.slope[0], rel=1e-6)
        assert together.intercept[row] == pytest.approx(alone.intercept[0], rel=1e-6)


@pytest.mark.slow
def test_resampled_intervals_hold_the_threshold_of_clustered_outcomes():
    """40 clusters of 3 observations with a shift each; the median curve has its threshold at 2."""
    rng, held = np.random.default_rng(1), 0
    for _ in range(40):
        cluster = np.repeat(np.arange(40), 3)
        x = rng.uniform(0.0, 4.0, 120)
        y = rng.random(120) < expit(4.0 * (2.0 + 0.3 * rng.standard_normal(40)[cluster] - x))
        low, high = percentile_interval(resampled(x, y, cluster).value_at(0.5))
        held += low <= 2.0 <= high
    assert held >= 34  # 38 are expected of an exact interval; fewer than 34 have a probability of 1 %
