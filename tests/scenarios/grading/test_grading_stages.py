"""Metrics of segmentation and outlier removal on scenes made by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support import naive_grading as naive
from support.frames import Body, Scripted, observe, trace_of, world_frame

from luxloop.scenarios.grading.frame_truth import NO_ACTOR_ROW, Ownership, point_rows
from luxloop.scenarios.grading.grader import Grader
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.sensor_model.truth import NO_ACTOR, Cause
from luxloop.sim.world import Kind
from luxloop.tracker.records import Segments

CARS = [Body(0, 30.0, 0.0), Body(1, 30.0, 8.0)]
"""Two cars of twenty points each: points 0 to 19 and 20 to 39 of the scan."""


def grade_one(bodies, label, noise=(), line=None):
    frame = world_frame(0, bodies)
    scan, truth = observe(frame, bodies, noise=noise)
    grader = Grader(GradingConfig())
    tracks, _ = Scripted([[]]).step(scan)
    grader.add(frame, scan, truth, tracks, trace_of(frame, truth, label=label, line=line))
    return grader.finish()


@pytest.mark.parametrize(
    ("label", "over", "under", "missed"),
    [
        ([0] * 20 + [1] * 20, 0.0, 0.0, 0.0),
        ([0] * 16 + [1] * 4 + [2] * 20, 0.5, 0.0, 0.0),
        ([0] * 17 + [1] * 3 + [2] * 20, 0.0, 0.0, 0.0),
        ([0] * 40, 0.0, 1.0, 0.0),
        ([0] * 20 + [0] * 5 + [1] * 15, 0.5, 0.5, 0.0),
        ([0] * 20 + [0] * 4 + [1] * 16, 0.5, 0.0, 0.0),
        ([0] * 20 + [-1] * 20, 0.0, 0.0, 0.5),
        ([0] * 20 + [1] * 10 + [2] * 10, 0.5, 0.0, 0.5),
        ([-1] * 40, 0.0, None, 1.0),
    ],
    ids=["exact", "a fifth split off", "less split off", "merged", "a quarter stolen", "a sixth stolen",
         "one lost", "one halved", "all lost"],
)  # fmt: skip
def test_segmentation_rates(label, over, under, missed):
    metrics, _ = grade_one(CARS, label)
    found = [metrics[f"segmentation.{name}_rate"].value for name in ("over", "under", "missed")]
    assert found == [over, under, missed]


def test_wall_in_a_vehicles_segment_is_under_segmentation():
    metrics, tables = grade_one([CARS[0]], [0] * 30, noise=[(NO_ACTOR, Cause.CLEAN)] * 10)
    assert metrics["segmentation.under_rate"].value == 1.0
    assert tables["segments"].second_share.tolist() == pytest.approx([1 / 3])


def test_segments_of_ungraded_actors_are_not_counted():
    walker = Body(2, 20.0, 0.0, kind=Kind.PEDESTRIAN)
    metrics, _ = grade_one([walker], [0] * 15 + [1] * 5)
    assert metrics["segmentation.over_rate"].value is None
    assert metrics["segmentation.under_rate"].value is None


def test_precision_and_recall_per_cause():
    # On car 0: 2 of 20 clean points are removed, 3 of 4 mirror points, and 0 of 5 overlap points.
    noise = [(0, Cause.MIRROR)] * 4 + [(0, Cause.LAYER_OVERLAP)] * 5
    line = [-1] * 2 + [0] * 18 + [-1] * 3 + [1] + [0] * 5
    metrics, _ = grade_one([CARS[0]], [0] * 29, noise, line)
    assert metrics["outliers.recall{cause=mirror}"].value == pytest.approx(3 / 4)
    assert metrics["outliers.precision{cause=mirror}"].value == pytest.approx(3 / 5)
    assert metrics["outliers.recall{cause=layer_overlap}"].value == 0.0
    assert metrics["outliers.precision{cause=layer_overlap}"].value == 0.0
    assert metrics["outliers.recall{cause=ghost}"].value is None
    assert "ghost" in metrics["outliers.precision{cause=ghost}"].reason


def test_ghosts_count_and_points_of_a_neighbour_do_not():
    # Segment 0: car 0, a quarter of car 1 (all removed), and two ghosts (one removed).
    noise = [(NO_ACTOR, Cause.GHOST)] * 2
    label = [0] * 20 + [0] * 5 + [1] * 15 + [0, 0]
    line = [0] * 20 + [-1] * 5 + [0] * 15 + [-1, 0]
    metrics, _ = grade_one(CARS, label, noise, line)
    assert metrics["outliers.recall{cause=ghost}"].value == 0.5
    assert metrics["outliers.precision{cause=ghost}"].value == 1.0


def test_precision_is_limited_to_segments_with_the_cause():
    # Car 0 has two mirror points, both removed, and loses one clean point; car 1 has none and loses five.
    label = [0] * 20 + [1] * 20 + [0, 0]
    line = [-1] + [0] * 19 + [-1] * 5 + [0] * 15 + [-1, -1]
    metrics, _ = grade_one(CARS, label, [(0, Cause.MIRROR)] * 2, line)
    assert metrics["outliers.precision{cause=mirror}"].value == pytest.approx(2 / 3)
    assert metrics["outliers.recall{cause=mirror}"].value == 1.0


def test_points_outside_of_vehicles_segments_do_not_count():
    metrics, tables = grade_one(CARS, [-1] * 44, [(0, Cause.MIRROR)] * 4, [-1] * 44)
    assert metrics["outliers.recall{cause=mirror}"].value is None
    assert tables["outliers"].points.sum() == 0


@given(
    st.lists(st.tuples(st.sampled_from((NO_ACTOR, 2, 5, 9)), st.integers(-1, 3)), max_size=40),
    st.lists(st.booleans(), min_size=3, max_size=3),
)
def test_ownership_equals_a_loop(points, graded):
    actor_id = np.array([2, 5, 9])
    actor = np.array([a for a, _ in points], dtype=np.int64)
    label = np.array([s for _, s in points], dtype=np.int64)
    owned = Ownership.of(point_rows(actor, actor_id), Segments(label, 4), np.array(graded), 0.5)
    expected = naive.counts(actor.tolist(), label.tolist(), actor_id.tolist(), 4)
    np.testing.assert_array_equal(owned.counts, expected)
    for s in range(4):
        owners = [a for a in range(3) if graded[a] and expected[a, s] > 0.5 * expected[:, s].sum()]
        assert owned.owner[s] == (owners[0] if owners else NO_ACTOR_ROW)
