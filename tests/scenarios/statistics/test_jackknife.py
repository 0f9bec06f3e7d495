"""Intervals over vehicles: by hand, equal to a loop that leaves out vehicles, and within the possible range."""

import math

import numpy as np
import pandas as pd
import pytest
import scipy
from support.frames import Body, Scripted, follow, grade_run

from luxloop.scenarios.grading.figures import of_rows
from luxloop.scenarios.grading.observations import Observations
from luxloop.scenarios.metrics.definitions import find_metric
from luxloop.scenarios.report.cells import interval_of
from luxloop.scenarios.statistics.intervals import NO_ERROR, TOO_FEW
from luxloop.scenarios.statistics.jackknife import (
    ANY,
    POSITIVE,
    SHARE,
    cluster_median_interval,
    effective_clusters,
    jackknife_interval,
    ratio_interval,
    std_interval,
)


def observations(vehicles, each, spread=1.0, seed=3):
    """Values with standard deviation `spread` between vehicles, and a small one from frame to frame."""
    rng = np.random.default_rng(seed)
    vehicle = np.repeat(np.arange(vehicles), each)
    return vehicle, 5.0 + spread * rng.normal(size=vehicles)[vehicle] + 0.01 * rng.normal(size=len(vehicle))


def figure(name, vehicle, **columns):
    """A metric of rows of these vehicles."""
    return of_rows(find_metric(name), Observations(pd.DataFrame({"actor_id": vehicle, **columns}), ""))


def test_equal_vehicles_have_the_textbook_interval_of_a_mean():
    """1, 2, 3: mean 2, deviation 1; t(0.975, 2) = 4.3027 (t table), so 2 +- 4.3027 / sqrt(3)."""
    vehicle, values = np.repeat([4, 7, 9], 10), np.repeat([1.0, 2.0, 3.0], 10)
    assert ratio_interval(vehicle, values, np.ones(30), ANY) == pytest.approx((2 - 2.4842, 2 + 2.4842), abs=1e-4)
    factor = math.exp(4.3027 / math.sqrt(3) / 2.0)
    assert ratio_interval(vehicle, values, np.ones(30), POSITIVE) == pytest.approx((2 / factor, 2 * factor), rel=1e-4)


def test_width_follows_from_the_number_of_vehicles_and_not_of_observations():
    """Fails when observations are the sample: with 100 per vehicle the interval would be ten times too narrow."""
    vehicle, values = observations(vehicles=80, each=100)
    low, high = ratio_interval(vehicle, values, np.ones(len(values)), ANY)
    assert high - low == pytest.approx(2 * 1.99 * values.reshape(80, 100).mean(axis=1).std() / math.sqrt(80), rel=0.02)


def test_interval_equals_a_loop_that_leaves_out_vehicles():
    rng = np.random.default_rng(8)
    vehicle = np.sort(rng.choice([3, 5, 11, 12, 40], 60))
    values, whole = rng.gamma(2.0, size=60), rng.uniform(0.5, 2.0, 60)
    rest = [values[vehicle != v].sum() / whole[vehicle != v].sum() for v in np.unique(vehicle)]
    own = np.array([whole[vehicle == v].sum() for v in np.unique(vehicle)])
    value = values.sum() / whole.sum()
    error = math.sqrt(4 / 5 * sum((one - value) ** 2 for one in rest))
    half = scipy.stats.t.ppf(0.975, own.sum() ** 2 / (own**2).sum() - 1) * error
    assert ratio_interval(vehicle, values, whole, ANY) == pytest.approx((value - half, value + half))
    deviations = np.array([np.std(values[vehicle != v]) for v in np.unique(vehicle)])
    number = np.unique(vehicle, return_counts=True)[1].astype(float)
    expected = jackknife_interval(float(np.std(values)), deviations, number, POSITIVE)
    assert std_interval(vehicle, values) == pytest.approx(expected)


@pytest.mark.parametrize("within", [SHARE, POSITIVE, (0.0, 1.2), (-0.9, 0.9), (-math.inf, 1.0)])
def test_interval_stays_within_the_possible_range(within):
    rng, shown = np.random.default_rng(5), 0
    for _ in range(50):
        vehicle, values = np.repeat(np.arange(4), 3), np.repeat(rng.beta(0.3, 0.3, 4), 3)
        found = ratio_interval(vehicle, values, np.ones(12), within)
        if found:
            shown += 1
            assert within[0] <= found[0] <= values.mean() <= found[1] <= within[1]
    two_ends = within in ((0.0, 1.2), (-0.9, 0.9))  # the scale keeps the others within their range
    assert 0 < shown < 50 if two_ends else shown == 50


def test_limits_that_say_nothing_are_no_interval():
    """Three equal vehicles: t(0.975, 2) = 4.3027. The error of 0, 0, 3 is 1, of 1, 1, 4 it is 1 on a mean of 2."""
    vehicle, ones = np.repeat([4, 7, 9], 10), np.ones(30)
    lone, shared = np.repeat([0.0, 0.0, 3.0], 10), np.repeat([1.0, 1.0, 4.0], 10)
    factor = math.exp(4.3027 * 1.0 / 2.0)
    assert ratio_interval(vehicle, shared, ones, POSITIVE) == pytest.approx((2.0 / factor, 2.0 * factor), rel=1e-4)
    assert ratio_interval(vehicle, shared, ones, (0.0, 2.0 * factor + 0.01)) is not None
    assert ratio_interval(vehicle, shared, ones, (0.0, 2.0 * factor - 0.01)) is None
    assert ratio_interval(vehicle, shared, ones, (-6.31, 6.31)) == pytest.approx((-2.3027, 6.3027), abs=1e-4)
    assert ratio_interval(vehicle, shared, ones, (-6.3, 6.3)) is None
    assert ratio_interval(vehicle, lone, ones, POSITIVE) == pytest.approx((1 / factor**2, factor**2), rel=1e-4)
    assert jackknife_interval(1.0, np.array([0.0, 1.5, 1.5]), np.ones(3), POSITIVE) is not None
    assert jackknife_interval(1.0, np.array([0.0, 2.0, 1.0]), np.ones(3), POSITIVE) is None  # error 1.15 of 1
    assert jackknife_interval(0.0, np.array([1.0, -1.0, 0.0]), np.ones(3), (-math.inf, 1.0)) is None


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("fit.heading_mean_deg", (-45.0, 45.0)),
        ("fit.heading_abs_mean_deg{view=rear}", (0.0, 45.0)),
        ("fit.heading_abs_std_deg", (0.0, 22.5)),
        ("fit.regret_deg{range=0-15}", (0.0, 45.0)),
        ("track.heading_abs_mean_deg", (0.0, 180.0)),
        ("track.mota", (-math.inf, 1.0)),
        ("track.hota", (0.0, 1.0)),
        ("fit.position_abs_mean_m", (0.0, math.inf)),
        ("fit.corner_across_mean_m", (-math.inf, math.inf)),
    ],
)
def test_ranges_are_those_of_the_quantities(name, expected):
    assert find_metric(name).definition.range == expected


def test_a_figure_of_vehicles_without_an_interval_says_why():
    """Two vehicles are too few; errors of 0 of many vehicles have no scale; a count never has an interval."""
    two, errors = np.repeat([0, 1], 5), np.arange(10.0)
    metrics = [
        figure("fit.heading_abs_mean_deg", two, best=True, heading_abs_error_deg=errors),
        figure("fit.heading_std_deg", two, best=True, heading_error_deg=errors),
        figure("fit.regret_deg", np.repeat(np.arange(5), 2), best=True, regret_deg=np.zeros(10)),
        figure("segmentation.over_rate", np.repeat(np.arange(5), 2), segmented=True, is_split=errors > 2),
    ]
    assert [metric.why_no_interval for metric in metrics] == [TOO_FEW, TOO_FEW, NO_ERROR, ""]
    assert [interval_of(metric) for metric in metrics] == [TOO_FEW, TOO_FEW, NO_ERROR, ""]


def test_none_of_eight_vehicles_is_the_rule_of_three():
    """1 - 0.05**(1/8) = 0.312: at most 3/8."""
    vehicle = np.repeat(np.arange(8), 5)
    assert ratio_interval(vehicle, np.zeros(40), np.ones(40), SHARE) == pytest.approx((0.0, 0.3123), abs=1e-4)
    assert ratio_interval(vehicle, np.ones(40), np.ones(40), SHARE) == pytest.approx((0.6877, 1.0), abs=1e-4)


def test_few_vehicles_or_a_dominant_one_have_no_interval():
    two = np.repeat([0, 1], 5)
    assert ratio_interval(two, np.arange(10.0), np.ones(10), ANY) is None
    assert std_interval(two, np.arange(10.0)) is None
    assert std_interval(two[:0], np.empty(0)) is None
    dominant = np.array([100.0, 1.0, 1.0, 1.0])
    assert effective_clusters(dominant) == pytest.approx(103**2 / 10003)
    assert jackknife_interval(1.0, np.array([0.9, 1.0, 1.1, 1.0]), dominant, ANY) is None
    nearly = np.array([10.0, 4.0, 4.0])
    assert effective_clusters(nearly) == pytest.approx(324 / 132)
    assert jackknife_interval(1.0, np.array([0.9, 1.0, 1.1]), nearly, SHARE) is None
    assert jackknife_interval(1.0, np.array([0.9, 1.0, 1.1]), np.full(3, 0.1), ANY) is not None  # 3 but for rounding


def test_vehicles_that_agree_do_not_make_a_share_certain():
    """A share of 0.9 of each of six vehicles: at most four independent observations of each, 21.6 of 24."""
    vehicle, values = np.repeat(np.arange(6), 10), np.tile([0.0] + [1.0] * 9, 6)
    expected = scipy.stats.beta.ppf((0.025, 0.975), (21.6, 22.6), (3.4, 2.4))
    assert ratio_interval(vehicle, values, np.ones(60), SHARE) == pytest.approx(expected)


def test_median_of_vehicles_with_one_value_each_is_near_that_of_order_statistics():
    values = np.random.default_rng(2).normal(size=101)
    low, high = cluster_median_interval(np.arange(101), values)
    ordered = np.sort(values)
    assert ordered[35] < low < ordered[43]  # the binomial interval of 101 / 2 is 40.6 to 60.4
    assert ordered[57] < high < ordered[65]
    assert cluster_median_interval(np.zeros(101, np.int64), values) is None


def test_means_and_deviations_over_vehicles_have_intervals_and_rates_of_points_have_none():
    vehicle, values = observations(vehicles=6, each=5)
    mean = figure("fit.heading_mean_deg", vehicle, best=True, heading_error_deg=values)
    deviation = figure("fit.heading_std_deg", vehicle, best=True, heading_error_deg=values)
    rate = figure("outliers.recall{cause=mirror}", vehicle, mirror=True, removed=1.0, points=2.0)
    assert [metric.interval is None for metric in (mean, deviation, rate)] == [False, False, True]
    assert (rate.value, rate.n) == (0.5, 60)
    assert mean.value == pytest.approx(values.mean())
    assert mean.interval[0] < mean.value < mean.interval[1]


def test_metrics_of_the_papers_tables_have_intervals_and_counts_do_not():
    scene = [[Body(k, 12.0 + 8 * k, 4.0 - 4 * k, speed=5.0) for k in range(3)]] * 4
    script = [[follow(body, x=body.x + 0.1 * (body.id + 1)) for body in bodies] for bodies in scene]
    metrics = grade_run(scene, Scripted(script))[0]
    position = metrics["mma.x_abs_mean_m{target=moving}"]
    assert position.value == pytest.approx(0.2)
    factor = math.exp(4.3027 * 0.1 / math.sqrt(3) / 0.2)
    assert position.interval == pytest.approx((0.2 / factor, 0.2 * factor), rel=1e-4)
    assert metrics["mma.mode_accuracy"].interval == pytest.approx((0.05 ** (1 / 3), 1.0))
    assert all(metric.interval is None for metric in metrics.values() if metric.unit == "count")
