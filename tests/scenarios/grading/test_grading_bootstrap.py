"""Bootstrap intervals over vehicles: equal to a loop over resamples, and with the theoretical width."""

import math

import numpy as np
import pytest
from support import naive_grading as naive
from support.frames import Body, Scripted, follow, grade_run

from scenarios.grading.bootstrap import RESAMPLES, Bootstrap
from scenarios.grading.metric_sheet import MetricSheet


def observations(vehicles, each, spread=1.0, seed=3):
    """Values with standard deviation `spread` between vehicles, and a small one from frame to frame."""
    rng = np.random.default_rng(seed)
    vehicle = np.repeat(np.arange(vehicles), each)
    return vehicle, 5.0 + spread * rng.normal(size=vehicles)[vehicle] + 0.01 * rng.normal(size=len(vehicle))


def test_width_of_the_interval_follows_from_the_number_of_vehicles():
    """Fails when observations are resampled: with 100 per vehicle the interval would be ten times too narrow."""
    vehicle, values = observations(vehicles=80, each=100)
    low, high = Bootstrap(vehicle).of_ratio(vehicle, values, np.ones(len(values)))
    of_vehicles = values.reshape(80, 100).mean(axis=1)
    expected = 2 * 1.96 * of_vehicles.std() / math.sqrt(80)
    assert high - low == pytest.approx(expected, rel=0.1)
    assert low < values.mean() < high


def test_interval_equals_a_loop_over_resamples():
    """The loop gathers all observations of the drawn vehicles, one resample after the other."""
    rng = np.random.default_rng(8)
    vehicle = np.sort(rng.choice([3, 5, 11, 12, 40], 60))
    values = rng.normal(size=60)
    bootstrap = Bootstrap(np.array([3, 5, 7, 11, 12, 40]))  # vehicle 7 has no value
    means, stds = naive.resampled(bootstrap, vehicle, values)
    assert len(means) == RESAMPLES
    assert bootstrap.of_ratio(vehicle, values, np.ones(60)) == pytest.approx(np.quantile(means, (0.025, 0.975)))
    assert bootstrap.of_std(vehicle, values) == pytest.approx(np.quantile(stds, (0.025, 0.975)))


def test_ratio_is_a_ratio_of_sums():
    vehicle, part, whole = np.array([0, 0, 1]), np.array([1.0, 2.0, 30.0]), np.array([1.0, 1.0, 10.0])
    low, high = Bootstrap(vehicle).of_ratio(vehicle, part, whole)
    assert (low, high) == pytest.approx((1.5, 3.0))  # of each vehicle alone


def test_one_vehicle_has_no_interval_and_intervals_are_reproducible():
    vehicle, values = observations(vehicles=6, each=5)
    one = np.zeros(30, dtype=np.int64)
    assert Bootstrap(vehicle).of_ratio(one, values, np.ones(30)) is None
    assert Bootstrap(vehicle).of_std(one, values) is None
    assert Bootstrap(np.empty(0, np.int64)).of_std(one[:0], values[:0]) is None
    assert Bootstrap(vehicle).of_std(vehicle, values) == Bootstrap(vehicle[::-1]).of_std(vehicle, values)


def test_sheet_has_intervals_for_values_with_vehicles_only():
    vehicle, values = observations(vehicles=6, each=5)
    sheet = MetricSheet(Bootstrap(vehicle))
    sheet.mean("fit.best.heading_mean_deg", values, "", vehicle)
    sheet.std("fit.best.heading_std_deg", values, "", vehicle)
    sheet.mean("fit.best.iou_mean", values, "")
    sheet.rate("outliers.mirror.recall", 1, 2, "")
    assert [m.interval is None for m in sheet.metrics.values()] == [False, False, True, True]
    mean = sheet.metrics["fit.best.heading_mean_deg"]
    assert mean.value == pytest.approx(values.mean())
    assert mean.interval[0] < mean.value < mean.interval[1]


def test_metrics_of_the_papers_tables_have_intervals_and_counts_do_not():
    scene = [[Body(0, 12.0, 4.0, speed=5.0), Body(1, 20.0, -4.0, speed=5.0)]] * 4
    script = [[follow(a, x=a.x + 0.1), follow(b, x=b.x + 0.3)] for a, b in scene]
    metrics = grade_run(scene, Scripted(script))[0]
    position = metrics["mma.mma.moving_target.x_abs_mean_m"]
    assert position.value == pytest.approx(0.2)
    assert position.interval == pytest.approx((0.1, 0.3))
    assert metrics["mma.mode_accuracy"].interval == (1.0, 1.0)
    assert all(metric.interval is None for metric in metrics.values() if metric.unit == "count")
