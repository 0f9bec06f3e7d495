"""Metrics of fits by view, range and points; coverage of the heading variance; corner and extents."""

import math
from dataclasses import replace

import numpy as np
import pytest
from support.frames import CAR_SIZE, Body, Scripted, grade_run, observe, trace_of, world_frame
from support.many_metrics import GRADED, STANDARD

from luxloop.scenarios.grading.body_points import Ranging
from luxloop.scenarios.grading.grader import Grader
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.metrics.definition import filtered
from luxloop.sensor_model.truth import Cause, View
from luxloop.tracker.records import METHODS

EXACT = (0.0,) * (len(METHODS) - 1)


class Values:
    """Values of metrics by name."""

    def __init__(self, metrics):
        self._metrics = metrics

    def __getitem__(self, name):
        return self._metrics[name].value


def graded(bodies, trace, frames=1):
    metrics, tables, _ = grade_run([bodies] * frames, Scripted([[]] * frames), trace=trace)
    return Values(metrics), tables["fits"], metrics


def turned(turns_deg, best=0):
    """Trace whose rectangles are exact except those of one method, turned by one angle per segment."""

    def trace(frame, truth):
        traced = trace_of(frame, truth, best=best)
        heading = traced.candidates.heading.copy()
        heading[:, best] += np.radians(turns_deg)
        boxes = replace(traced.boxes, heading=heading[:, best])
        return replace(traced, candidates=replace(traced.candidates, heading=heading), boxes=boxes)

    return trace


def test_heading_and_regret_by_range_and_by_points():
    """Ranges 14.9, 15, 30 and 40 m with 29, 30, 100 and 150 points: the upper end belongs to the next band."""
    bodies = [
        Body(0, 14.9, 0.0, points=29),
        Body(1, 0.0, 15.0, points=30),
        Body(2, -30.0, 0.0, points=100),
        Body(3, 0.0, -40.0, points=150),
    ]
    value, _, metrics = graded(bodies, turned([1.0, 2.0, 4.0, 8.0]))
    by_range = {"0-15": 1.0, "15-30": 2.0, "30-50": 6.0}
    by_points = {"0-30": 1.0, "30-100": 2.0, "100-": 6.0}
    for kind, expected in (("range", by_range), ("points", by_points)):
        for band, error in expected.items():
            heading, within = "fit.heading_abs_mean_deg", {kind: band}
            assert value[filtered(heading, **within)] == pytest.approx(error)
            assert value[filtered(heading, method="area", **within)] == pytest.approx(error)
            assert value[filtered(heading, method="variance", **within)] == pytest.approx(0.0, abs=1e-9)
            assert value[filtered("fit.regret_deg", **within)] == pytest.approx(error)
    # Four vehicles: mean 3.75, standard error sqrt(28.75 / 3) / 2 = 1.548, Student's quantile 3.1824.
    factor = np.exp(3.1824 * np.sqrt(28.75 / 3) / 2 / 3.75)
    assert metrics["fit.regret_deg"].interval == pytest.approx((3.75 / factor, 3.75 * factor), rel=1e-3)
    assert metrics["fit.regret_deg{range=30-50}"].interval is None  # two vehicles


def test_a_band_without_observations_has_a_reason():
    _, _, metrics = graded([Body(0, 14.9, 0.0)], turned([1.0]))
    metric = metrics["fit.regret_deg{range=30-50}"]
    assert (metric.value, metric.n, metric.reason) == (None, 0, "no observation has range 30-50")
    assert "baselines" in metrics["fit.heading_abs_mean_deg{method=jlinkage,range=0-15}"].reason


def test_regret_by_view():
    bodies = [Body(0, 30.0, 0.0, view=View.REAR), Body(1, 30.0, 8.0, view=View.L_SHAPE)]
    value, _, _ = graded(bodies, turned([3.0, 1.0]))
    assert value["fit.regret_deg{view=rear}"] == pytest.approx(3.0)
    assert value["fit.regret_deg{view=l_shape}"] == pytest.approx(1.0)
    assert value["fit.regret_deg"] == pytest.approx(2.0)
    assert value["fit.regret_deg{view=side}"] is None


def test_coverage_of_the_intervals_by_hand():
    """With a standard deviation of 1 degree the intervals end at 0.6745, 1.6449 and 2.5758 degrees."""
    errors = np.array([0.67, -0.68, 1.64, 1.65, -2.57, 2.58, 90.5, -89.0])
    bodies = [Body(k, 5.0 + 5.0 * k, 0.0, view=View.REAR if k % 2 else View.SIDE) for k in range(len(errors))]

    def trace(frame, truth):
        traced = turned(errors)(frame, truth)
        covariance = np.tile(np.diag([0.01, 0.01, math.radians(1.0) ** 2]), (len(errors), 1, 1))
        return replace(traced, boxes=replace(traced.boxes, covariance=covariance))

    value, fits, _ = graded(bodies, trace)
    assert [value[f"fit.coverage_{p}"] for p in (50, 90, 99)] == [2 / 8, 5 / 8, 7 / 8]
    assert [value[f"fit.coverage_{p}{{view=side}}"] for p in (50, 90, 99)] == [2 / 4, 3 / 4, 1.0]
    assert fits["box_heading_std_deg"].tolist() == pytest.approx([1.0] * len(fits))


def test_segments_without_a_box_do_not_count_for_the_coverage():
    """Fails when a box is taken for that of another segment."""

    def trace(frame, truth):
        traced = turned([5.0, 0.0, 0.0])(frame, truth)
        boxes = replace(traced.boxes, covariance=np.tile(np.eye(3) * math.radians(1.0) ** 2, (3, 1, 1)))
        return replace(traced, boxes=boxes.subset(np.array([2, 0])))

    _, fits, metrics = graded([Body(0, 10.0, 0.0), Body(1, 20.0, 0.0), Body(2, 30.0, 0.0)], trace)
    best = fits[fits["best"]]
    assert best["box_heading_error_deg"].tolist() == pytest.approx([5.0, math.nan, 0.0], nan_ok=True)
    metric = metrics["fit.coverage_99"]
    assert (metric.value, metric.n) == (0.5, 2)


@pytest.mark.parametrize("quarter", [0, 1, 2, 3])
def test_corner_error_along_and_across_is_positive_outside_the_true_box(quarter):
    """A car ahead of the ego at yaw 0.3: its rear right corner is nearest, here 0.2 m outside and 0.1 m inside.

    The rectangle's heading may be any quarter turn from the vehicle's.
    """
    body = Body(0, 20.0, 15.0, yaw=0.3)
    grow = np.array([0.4, -0.2])  # twice the error of the corner, about the same opposite corner

    def trace(frame, truth):
        traced = trace_of(frame, truth)
        fitted, turn = traced.candidates, quarter * math.pi / 2
        forward, left = np.array([math.cos(0.3), math.sin(0.3)]), np.array([-math.sin(0.3), math.cos(0.3)])
        center = fitted.center_ego - 0.25 * (grow[0] * forward + grow[1] * left)
        size = np.array(CAR_SIZE[:2]) + 0.5 * grow
        size = size[::-1] if quarter % 2 else size
        return replace(
            traced,
            candidates=replace(
                fitted, heading=fitted.heading + turn, center_ego=center, size=np.broadcast_to(size, fitted.size.shape)
            ),
        )

    value, _, _ = graded([body], trace)
    assert value["fit.corner_along_mean_m"] == pytest.approx(0.2)
    assert value["fit.corner_across_mean_m"] == pytest.approx(-0.1)
    assert value["fit.corner_across_abs_mean_m"] == pytest.approx(0.1)
    assert value["fit.position_abs_mean_m"] == pytest.approx(math.hypot(0.2, 0.1))


@pytest.mark.parametrize("sideways", [False, True])
def test_extents_are_compared_with_those_of_the_true_points(sideways):
    """Range noise and points off the body do not change the visible extents, which are 3.0 by 0.4 m."""
    body = Body(0, 20.0, 0.0, points=12)
    frame = world_frame(0, [body])
    scan, truth = observe(frame, [body])
    origin = np.array([1.0, 0.5, 0.6])
    local = np.array([(-2.3 + 3.0 * k / 9, -0.9 + 0.4 * k / 9) for k in range(10)] + [(0.0, 1.1), (2.0, 2.0)])
    points = np.column_stack([local[:, 0] + 20.0, local[:, 1], np.full(12, 0.6)])
    distance = np.linalg.norm(points - origin, axis=1)
    noisy = origin + (points - origin) * (1.0 + 0.1 / distance)[:, None]
    cause = np.array([Cause.CLEAN] * 8 + [Cause.LAYER_OVERLAP, Cause.DOUBLED, Cause.MIRROR, Cause.RANGE_OUTLIER])
    scan = replace(scan, points_ego=noisy.astype(np.float32))
    truth = replace(truth, true_range=distance.astype(np.float32), cause=cause.astype(np.uint8))
    traced = trace_of(frame, truth)
    if sideways:
        fitted = traced.candidates
        turned_size = fitted.size[..., ::-1]
        traced = replace(traced, candidates=replace(fitted, heading=fitted.heading + math.pi / 2, size=turned_size))
    grader = Grader(GradingConfig(), Ranging(origin[None], np.full(1, 0.02)))
    tracks, _ = Scripted([[]]).step(scan)
    grader.add(frame, scan, truth, tracks, traced)
    metrics, tables = grader.finish()
    assert tables["fits"][["seen_length_m", "seen_width_m"]].to_numpy()[0] == pytest.approx([3.0, 0.4], abs=1e-5)
    assert metrics["fit.extent_along_mean_m"].value == pytest.approx(CAR_SIZE[0] - 3.0, abs=1e-5)
    assert metrics["fit.extent_across_abs_mean_m"].value == pytest.approx(CAR_SIZE[1] - 0.4, abs=1e-5)


def test_without_a_rig_the_extents_have_a_reason():
    _, _, metrics = graded([Body(0, 20.0, 0.0)], turned([0.0]))
    assert "no rig" in metrics["fit.extent_along_mean_m"].reason


def test_every_scope_is_in_every_result():
    _, _, metrics = graded([Body(0, 20.0, 0.0)], turned([0.0]))
    assert set(metrics) == set(STANDARD) & set(GRADED)
    assert all(metrics[name].value is not None or metrics[name].reason for name in GRADED)
