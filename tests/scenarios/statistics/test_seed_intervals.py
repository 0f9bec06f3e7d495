"""Intervals over seeds: published and hand-computed values, exact coverage, and warnings."""

import numpy as np
import pytest
import scipy

from luxloop.scenarios.statistics.intervals import (
    binomial_interval,
    bounded_mean_interval,
    few_seeds,
    is_dominated,
    median_interval,
    mid_p_interval,
)


def test_five_values_have_their_extremes_and_four_no_interval():
    assert median_interval(np.array([3.0, 9.0, 1.0, 40.0, 2.0])) == (1.0, 40.0)
    assert median_interval(np.array([3.0, 9.0, 1.0, 40.0])) is None


def test_ten_values_have_the_published_interpolation():
    """Hettmansperger and Sheather 1986 by hand: ranks 2 and 3 of ten cover 0.97852 and 0.89063.

    (0.97852 - 0.95) / (0.97852 - 0.89063) = 0.3245; weight 8 * 0.3245 / (2 + 6 * 0.3245) = 0.6577 of the third value.
    """
    low, high = median_interval(np.arange(1.0, 11.0))
    assert (low, high) == pytest.approx((2.6577, 8.3423), abs=2e-4)


@pytest.mark.parametrize("n", [5, 8, 12])
@pytest.mark.parametrize("draw", ["lognormal", "normal", "exponential"])
def test_the_median_is_covered_whatever_the_distribution(n, draw):
    rng, quantile = np.random.default_rng(n), {"lognormal": 1.0, "normal": 0.0, "exponential": np.log(2.0)}[draw]
    values = {"lognormal": rng.lognormal(sigma=2.0, size=(2000, n)), "normal": rng.normal(size=(2000, n)),
              "exponential": rng.exponential(size=(2000, n))}[draw]  # fmt: skip
    inside = [low <= quantile <= high for low, high in map(median_interval, values)]
    assert 0.92 <= np.mean(inside) <= 0.97  # 0.9375 for five, 0.95 for others; the standard error is 0.005


def test_mid_p_interval_agrees_with_published_values():
    """Newcombe 1998, Statistics in Medicine 17, table I, method 6 (mid-p): 81 of 263, 15 of 148, 0 of 20, 1 of 29."""
    assert mid_p_interval(81, 263) == pytest.approx((0.2544, 0.3658), abs=1e-4)
    assert mid_p_interval(15, 148) == pytest.approx((0.0601, 0.1581), abs=1e-4)
    assert mid_p_interval(0, 20) == pytest.approx((0.0, 0.1391), abs=1e-4)
    assert mid_p_interval(1, 29) == pytest.approx((0.0017, 0.1585), abs=1e-4)


def test_none_in_n_seeds_is_the_rule_of_three():
    for n in (5, 8, 12):
        low, high = bounded_mean_interval(np.zeros(n))
        assert (low, high) == (0.0, pytest.approx(1 - 0.05 ** (1 / n)))
        assert high < 3 / n
    assert bounded_mean_interval(np.zeros(8), -1.0, 1.0) != (0.0, 0.0)


def test_draws_agree_with_the_exact_interval():
    """A value that is hardly off the end is drawn; the exact interval of the same values without that is close."""
    values = np.array([0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    drawn = bounded_mean_interval(np.append(values[:-1], 1.0 - 1e-9))
    assert drawn == pytest.approx(bounded_mean_interval(values), abs=0.012)
    assert bounded_mean_interval(2 * values - 1, -1.0, 1.0) == pytest.approx(
        tuple(2 * end - 1 for end in bounded_mean_interval(values))
    )


def test_few_distinct_values_stay_within_the_range():
    low, high = bounded_mean_interval(np.array([0.5, 0.5, 1.0, 0.75, 1.0]))
    assert 0.0 <= low < 0.75 < high <= 1.0


def test_binomial_interval_is_clopper_s_and_pearson_s():
    """Newcombe's method 5 (exact): 15 of 148."""
    (low,), (high,) = binomial_interval(np.array([15 / 148]), np.array([148.0]))
    assert (low, high) == pytest.approx((0.0579, 0.1617), abs=1e-4)
    exact = scipy.stats.binomtest(15, 148).proportion_ci(method="exact")
    assert (low, high) == pytest.approx((exact.low, exact.high))


def test_warnings():
    assert few_seeds(10) == ""
    assert few_seeds(5).startswith("only 5 seeds")
    assert is_dominated(np.array([0.1, 0.2, 0.1, 9.0]))
    assert not is_dominated(np.array([1.0, 2.0, 1.0, 3.0]))
    assert not is_dominated(np.zeros(5))
