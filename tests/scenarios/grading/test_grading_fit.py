import math
from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd
import pytest
from support.frames import Body, Scripted, grade_run, observe, trace_of, world_frame

from luxloop.scenarios.grading.fit_errors import BOX, TRUE_BOX, errors, measure
from luxloop.scenarios.grading.grader import Grader
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.metrics.definitions import standard_names
from luxloop.sensor_model.truth import NO_ACTOR, Cause, View
from luxloop.tracker.records import BASELINES, METHODS

EGO = ((20.0, -10.0, 0.7), (0.0, 0.0, 0.0))


def grade_trace(scene, trace):
    return grade_run(scene, Scripted([[]] * len(scene)), ego=lambda _: EGO, trace=trace)


def test_heading_errors_by_method_modulo_a_quarter_turn():
    # area 10, closeness -1.9, variance 46 (that is -44), tlinkage 90.5 (that is 0.5), refined like variance.
    scene = [[Body(3, 30.0, -5.0, yaw=2.9)], [Body(3, 31.0, -5.0, yaw=2.9)]]
    metrics, tables, grades = grade_trace(scene, partial(trace_of, turn_deg=(10.0, -1.9, 46.0, 90.5, 46.0)))

    def value(name):
        return metrics[f"fit.{name}"].value

    means = [value(f"heading_mean_deg{{method={m}}}") for m in ("area", "closeness", "variance", "tlinkage", "oracle")]
    assert means == pytest.approx([10.0, -1.9, -44.0, 0.5, 0.5])
    assert value("heading_abs_mean_deg") == pytest.approx(44.0)
    assert value("regret_deg") == pytest.approx(44.0 - 0.5)
    assert [value(f"within_{k}deg{{method=closeness}}") for k in range(1, 6)] == [0, 1, 1, 1, 1]
    assert metrics["fit.heading_mean_deg{method=area}"].n == 2
    assert len(tables["fits"]) == 2 * len(METHODS)
    np.testing.assert_allclose(np.degrees(grades[0].box_heading_error), [-44.0])
    assert grades[0].box_actor.tolist() == [3]


def test_std_of_signed_and_absolute_errors():
    scene = [[Body(0, 30.0, 0.0)], [Body(0, 30.0, 0.0)]]
    turns = iter([(3.0,) * len(METHODS), (-1.0,) * len(METHODS)])
    metrics, _, _ = grade_trace(scene, lambda frame, truth: trace_of(frame, truth, turn_deg=next(turns)))
    found = [metrics[f"fit.heading_{s}_deg{{method=area}}"].value for s in ("mean", "std", "abs_mean", "abs_std")]
    assert found == pytest.approx([1.0, 2.0, 2.0, 1.0])


def test_views_are_graded_separately_and_missing_views_have_no_value():
    scene = [[Body(0, 30.0, 0.0, view=View.REAR), Body(1, 30.0, 8.0, view=View.L_SHAPE)]]

    def trace(frame, truth):
        traced = trace_of(frame, truth)
        heading = traced.candidates.heading + np.radians([[4.0], [1.0]])
        return replace(traced, candidates=replace(traced.candidates, heading=heading))

    metrics, tables, _ = grade_trace(scene, trace)
    assert tables["fits"].groupby("actor_id").heading_error_deg.mean().tolist() == pytest.approx([4.0, 1.0])
    assert metrics["fit.heading_mean_deg{method=area,view=rear}"].value == pytest.approx(4.0)
    assert metrics["fit.heading_mean_deg{view=l_shape}"].value == pytest.approx(1.0)
    assert metrics["fit.heading_mean_deg"].value == pytest.approx(2.5)
    assert metrics["fit.heading_mean_deg{view=side}"].value is None
    assert "side" in metrics["fit.heading_mean_deg{view=side}"].reason


def test_position_error_of_the_nearest_corner_and_overlap_of_the_box():
    # A perfect fit shifted by 0.3 m along x and 0.4 m along y of the ego.
    def trace(frame, truth):
        traced = trace_of(frame, truth)
        moved = traced.candidates.center_ego + np.array([0.3, 0.4])
        return replace(traced, candidates=replace(traced.candidates, center_ego=moved))

    scene = [[Body(0, 27.0, -3.0, yaw=0.7)]]  # straight ahead of the ego and aligned with it
    metrics, _, _ = grade_trace(scene, trace)
    assert metrics["fit.position_abs_mean_m"].value == pytest.approx(0.5)
    shared = (4.6 - 0.3) * (1.8 - 0.4)
    assert metrics["fit.iou_mean"].value == pytest.approx(shared / (2 * 4.6 * 1.8 - shared))


def test_position_error_of_a_vehicle_abreast_does_not_include_its_length():
    # Abreast, two corners are equally near: 1 cm decides the nearest corner of the rectangle and of the true box.
    def trace(frame, truth):
        traced = trace_of(frame, truth)
        moved = traced.candidates.center_ego - np.array([0.02, 0.0])
        return replace(traced, candidates=replace(traced.candidates, center_ego=moved))

    frame_ego = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    metrics, _, _ = grade_run([[Body(0, 0.01, 4.0)]], Scripted([[]]), ego=lambda _: frame_ego, trace=trace)
    assert metrics["fit.position_abs_mean_m"].value == pytest.approx(0.02)


@pytest.mark.parametrize(("own", "other", "observed"), [(13, 12, 1), (12, 12, 0), (12, 13, 0)])
def test_observation_is_a_segment_with_most_points_of_one_graded_vehicle(own, other, observed):
    bodies = [Body(0, 30.0, 0.0, points=own)]
    frame = world_frame(0, bodies)
    scan, truth = observe(frame, bodies, noise=[(NO_ACTOR, Cause.CLEAN)] * other)
    grader = Grader(GradingConfig())
    tracks, _ = Scripted([[]]).step(scan)
    grade = grader.add(frame, scan, truth, tracks, trace_of(frame, truth, label=[0] * (own + other)))
    metrics, _ = grader.finish()
    assert metrics["fit.heading_mean_deg"].n == observed
    assert (grade.box_actor[0] == 0) == bool(observed)


def test_only_the_larger_of_two_segments_of_a_vehicle_is_observed():
    """Fails when a fragment counts as a second observation, or replaces the larger segment, in either order."""
    bodies = [Body(0, 30.0, 0.0, points=20)]
    frame = world_frame(0, bodies)
    scan, truth = observe(frame, bodies)
    for label, larger in (([0] * 6 + [1] * 14, 1), ([0] * 14 + [1] * 6, 0)):
        grader = Grader(GradingConfig())
        tracks, _ = Scripted([[]]).step(scan)
        grader.add(frame, scan, truth, tracks, trace_of(frame, truth, label=label))
        metrics, tables = grader.finish()
        assert metrics["fit.heading_mean_deg"].n == 1
        assert set(tables["fits"].segment) == {larger}


def test_coverage_counts_observations_without_a_fit():
    """Fails when omitting difficult vehicles from the segments has no effect."""
    bodies = [Body(0, 30.0, 0.0), Body(1, 30.0, 8.0)]
    label = [0] * 20 + [-1] * 20
    metrics, _, _ = grade_run([bodies] * 2, Scripted([[]] * 2), trace=lambda f, t: trace_of(f, t, label=label))
    assert (metrics["fit.coverage"].value, metrics["fit.coverage"].n) == (0.5, 4)


def test_method_without_a_rectangle_does_not_count_and_oracle_selects_among_the_others():
    def trace(frame, truth):
        traced = trace_of(frame, truth, turn_deg=(5.0, 3.0, 1.0, 0.0, 2.0), best=3)
        heading, center = traced.candidates.heading.copy(), traced.candidates.center_ego.copy()
        heading[:, 3], center[:, 3] = np.nan, np.nan
        return replace(traced, candidates=replace(traced.candidates, heading=heading, center_ego=center))

    metrics, _, _ = grade_trace([[Body(0, 30.0, 0.0)]], trace)
    assert metrics["fit.heading_mean_deg{method=tlinkage}"].value is None
    assert metrics["fit.regret_deg"].value is None
    assert metrics["fit.heading_mean_deg{method=oracle}"].value == pytest.approx(1.0)


def turns(order=METHODS, otherwise=5.0, **by_name):
    """Rotations of methods in their order, some given by name [deg]."""
    return tuple(by_name.get(name, otherwise) for name in order)


def with_baselines(traced, frame, **turn_deg):
    """Add a column for each baseline to the trace: the true box rotated by `turn_deg`, or NaN without one."""
    fitted, count = traced.candidates, traced.segments.count
    turned = frame.actors.pose_world[0, 2] + np.radians(turns(BASELINES, np.nan, **turn_deg))

    def wider(values):
        return np.concatenate([values, np.repeat(values[:, :1], len(BASELINES), axis=1)], axis=1)

    candidates = replace(
        fitted,
        heading=np.column_stack([fitted.heading, np.tile(turned, (count, 1))]),
        center_ego=wider(fitted.center_ego),
        size=wider(fitted.size),
        cost=wider(fitted.cost),
    )
    return replace(traced, candidates=candidates)


def test_enabled_baselines_are_graded_by_name_and_are_never_the_oracle():
    """Fails when the figures of methods are exchanged, or the regret includes baselines, which are not selectable."""

    def trace(frame, truth):
        traced = trace_of(frame, truth, turn_deg=turns(variance=3.0, tlinkage=2.0))
        return with_baselines(traced, frame, two_set_split=-1.5, ransac_lines=0.0)

    metrics, tables, _ = grade_run([[Body(0, 30.0, 0.0)]] * 2, Scripted([[]] * 2), trace=trace)
    assert tables["fits"]["method"].tolist() == [*METHODS, "two_set_split", "ransac_lines"] * 2
    assert metrics["fit.heading_mean_deg{method=two_set_split}"].value == pytest.approx(-1.5)
    assert metrics["fit.heading_mean_deg{method=ransac_lines}"].value == pytest.approx(0.0)
    assert metrics["fit.heading_mean_deg{method=principal_axes}"].value is None
    assert metrics["fit.heading_mean_deg{method=oracle}"].value == pytest.approx(2.0)
    assert metrics["fit.regret_deg"].value == pytest.approx(1.0)


def test_regret_counts_observations_with_a_selected_rectangle_only():
    """Fails when observations without a selected rectangle enter the oracle's mean."""
    frames = iter([turns(otherwise=8.0), turns(variance=np.nan, tlinkage=2.0)])  # variance is the one selected

    def trace(frame, truth):
        turn = next(frames)
        heading = np.where(np.isfinite(turn), turn, 0.0)
        traced = trace_of(frame, truth, turn_deg=heading)
        columns = np.where(np.isfinite(turn), traced.candidates.heading, np.nan)
        return replace(traced, candidates=replace(traced.candidates, heading=columns))

    metrics, _, _ = grade_run([[Body(0, 30.0, 0.0)]] * 2, Scripted([[]] * 2), trace=trace)
    assert metrics["fit.heading_abs_mean_deg{method=oracle}"].value == pytest.approx(5.0)
    assert (metrics["fit.regret_deg"].value, metrics["fit.regret_deg"].n) == (pytest.approx(0.0, abs=1e-9), 1)


def test_without_a_trace_every_stage_metric_has_this_reason():
    metrics, tables, grades = grade_run([[Body(0, 10.0, 0.0)]], Scripted([[]]))
    stages = [name for name in standard_names() if name.startswith(("fit.", "segmentation.", "outliers."))]
    assert {metrics[name].reason for name in stages} == {"the tracker does not report a trace of its stages"}
    assert len(measure(tables["fits"])) == 0
    assert grades[0].box_actor.shape == (0,)


def test_rotation_about_the_centre_moves_the_corner_by_the_chord():
    metrics, _, _ = grade_trace([[Body(0, 30.0, 0.0)]], partial(trace_of, turn_deg=(6.0,) * len(METHODS)))
    chord = math.hypot(4.6, 1.8) * math.sin(math.radians(3.0))
    assert metrics["fit.position_abs_mean_m{method=area}"].value == pytest.approx(chord)


@pytest.mark.parametrize("quarters", [0, 1, 2, 3, -5])
def test_a_side_that_was_taken_for_the_front_exchanges_the_extents_of_a_rectangle(quarters):
    """A rectangle 0.2 m too short and 0.1 m too wide about the right centre, its heading off by quarter turns."""
    sides = (4.4, 1.9) if quarters % 2 == 0 else (1.9, 4.4)
    box = dict(zip(BOX, (20.0, 3.0, 0.2 + quarters * np.pi / 2, *sides), strict=True))
    true = dict(zip(TRUE_BOX, (20.0, 3.0, 0.2, 4.6, 1.8), strict=True))
    fits = pd.DataFrame([{**box, **true, "seen_length_m": 4.6, "seen_width_m": 1.8, "box_heading_ego_rad": 0.2}])
    (found,) = errors(fits).to_dict("records")
    assert (found["extent_along_error_m"], found["extent_across_error_m"]) == pytest.approx((-0.2, 0.1))
    assert (found["corner_along_error_m"], found["corner_across_error_m"]) == pytest.approx((-0.1, 0.05))
    assert found["heading_error_deg"] == pytest.approx(0.0, abs=1e-9)
