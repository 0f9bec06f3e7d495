"""Tracking metrics with trackeval, on cases computed by hand."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support import naive_grading as naive
from support.frames import Body, Estimate, Scripted, drive, follow, grade_run
from support.many_metrics import GRADED, STANDARD
from support.stub_trackers import Perfect

from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.matching import TrackMatcher
from luxloop.scenarios.grading.plane_geometry import iou_table
from luxloop.sim.world import Kind
from luxloop.tracker.records import Status

FRAMES = 10


def car(actor, index, y, speed=10.0, **changes):
    x, _ = drive(-4.0, y, 0.0, speed, index)
    return Body(actor, x, y, 0.0, speed, **changes)


TWO_CARS = [[car(0, i, 5.0), car(1, i, -5.0)] for i in range(FRAMES)]
ONE_CAR = [[car(0, i, 5.0)] for i in range(FRAMES)]


def values(metrics, *names):
    return [metrics[f"track.{name}"].value for name in names]


def run(scene, script, **options):
    return grade_run(scene, Scripted(script), **options)[0]


def test_perfect_tracker_has_scores_of_one_and_no_errors():
    metrics = run(TWO_CARS, [[follow(body) for body in bodies] for bodies in TWO_CARS])
    scores = values(metrics, "hota", "deta", "assa", "loca", "mota", "idf1")
    assert scores == pytest.approx([1.0] * 6)
    assert values(metrics, "id_switches", "fragments", "missed", "false") == [0, 0, 0, 0]
    assert metrics["track.hota"].n == 2 * FRAMES
    assert set(metrics) == set(STANDARD) & set(GRADED)


def test_ids_swapped_once_half_way():
    script = [[follow(a, 0 if i < 5 else 1), follow(b, 1 if i < 5 else 0)] for i, (a, b) in enumerate(TWO_CARS)]
    metrics = run(TWO_CARS, script)
    # The association of every hit is 5 / (10 + 10 - 5) = 1/3, detection is perfect (Luiten 2021, equations 1 to 3).
    assert values(metrics, "hota", "assa") == pytest.approx([math.sqrt(1 / 3), 1 / 3])
    # Two switches in 20; of 20 vehicle frames, 10 keep their identity.
    assert values(metrics, "mota", "idf1", "id_switches") == pytest.approx([18 / 20, 0.5, 2])


def test_one_false_track_beside_one_vehicle():
    script = [[follow(body), Estimate(7, 0.0, 25.0)] for (body,) in ONE_CAR]
    metrics = run(ONE_CAR, script)
    assert values(metrics, "hota", "mota", "idf1") == pytest.approx([math.sqrt(1 / 2), 0.0, 2 / 3])
    assert values(metrics, "false", "missed") == [FRAMES, 0]


def test_one_missed_frame():
    script = [[follow(b)] if i == 4 else [follow(a), follow(b)] for i, (a, b) in enumerate(TWO_CARS)]
    metrics = run(TWO_CARS, script)
    # 19 of 20 detections; association 1 for ten hits of one car, 9/10 for nine of the other.
    assert values(metrics, "hota") == pytest.approx([math.sqrt(19 / 20 * (10 + 9 * 0.9) / 19)])
    assert values(metrics, "mota", "idf1") == pytest.approx([19 / 20, 19 / 19.5])
    assert values(metrics, "missed", "fragments", "id_switches") == [1, 1, 0]


def test_duplicate_track_is_false():
    script = [[follow(body), follow(body, track_id=9)] for (body,) in ONE_CAR]
    metrics = run(ONE_CAR, script)
    assert values(metrics, "false", "missed", "id_switches") == [FRAMES, 0, 0]


@pytest.mark.parametrize(
    "ungraded",
    [
        Body(5, 0.0, 15.0, kind=Kind.PEDESTRIAN, size=(0.5, 0.5, 1.7)),
        Body(5, 0.0, 15.0, points=9),
        Body(5, 0.0, 51.0),
    ],
    ids=["pedestrian", "nine points", "51 m away"],
)
@pytest.mark.parametrize("offset_m", [0.0, 0.4], ids=["on it", "overlapping it by 0.11 or more"])
def test_track_on_an_ungraded_actor_does_not_count(ungraded, offset_m):
    scene = [[*bodies, ungraded] for bodies in ONE_CAR]
    script = [[follow(body), follow(ungraded, y=ungraded.y + offset_m)] for (body,) in ONE_CAR]
    metrics, tables, grades = grade_run(scene, Scripted(script))
    assert values(metrics, "hota", "false", "missed") == pytest.approx([1.0, 0, 0])
    assert (tables["tracks"].query("track_id == 5").verdict == "ungraded").all()
    assert grades[0].graded.tolist() == [True, False]


def test_track_that_only_touches_an_ungraded_actor_is_false():
    pedestrian = Body(5, 0.0, 15.0, kind=Kind.PEDESTRIAN, size=(0.5, 0.5, 1.7))
    scene = [[*bodies, pedestrian] for bodies in ONE_CAR]
    # The overlap is 0.05 / 0.95 = 0.053 of the union.
    script = [[follow(body), follow(pedestrian, y=15.45)] for (body,) in ONE_CAR]
    metrics = run(scene, script)
    assert values(metrics, "false", "false_on_nothing") == [FRAMES, FRAMES]


def test_graded_vehicles_have_ten_points_and_are_within_fifty_metres():
    bodies = [Body(0, 50.0, 0.0), Body(1, 50.01, 10.0), Body(2, 5.0, 5.0, points=10), Body(3, 5.0, -5.0, points=9)]
    _, _, grades = grade_run([bodies], Scripted([[]]))
    assert grades[0].graded.tolist() == [True, False, True, False]
    assert grades[0].points.tolist() == [20, 20, 10, 9]


def test_unmatched_track_is_false_within_the_graded_range_only():
    script = [[follow(body), Estimate(7, 0.0, 49.0), Estimate(8, 0.0, 51.0)] for (body,) in ONE_CAR]
    metrics, tables, _ = grade_run(ONE_CAR, Scripted(script))
    assert values(metrics, "false") == [FRAMES]
    assert (tables["tracks"].query("track_id == 8").verdict == "outside").all()


def test_only_confirmed_tracks_are_reported():
    def hits(status):
        return run(ONE_CAR, [[follow(body, status=status)] for (body,) in ONE_CAR])["track.missed"].value

    found = [hits(Status(s)) for s in (Status.CONFIRMED, Status.COASTING, Status.TENTATIVE, Status.DEAD)]
    assert found == [0, FRAMES, FRAMES, FRAMES]


def test_pair_is_kept_while_it_overlaps_although_another_track_fits_better():
    # From frame 5 on, a second track fits exactly, the first one only by 3.6 / 5.6.
    def estimates(i, body):
        first = follow(body, x=body.x + (1.0 if i >= 5 else 0.0))
        return [first, follow(body, track_id=1)] if i >= 5 else [first]

    script = [estimates(i, body) for i, (body,) in enumerate(ONE_CAR)]
    _, _, grades = grade_run(ONE_CAR, Scripted(script))
    assert [grade.track_actor.tolist() for grade in grades[4:6]] == [[0], [0, -1]]


def test_only_pairs_of_the_last_frame_are_kept():
    """A track that lost its car to another one does not get it back by fitting better."""
    matcher, one = TrackMatcher(GradingConfig()), np.array([0])
    overlaps = [[0.9, 0.0], [0.0, 0.6], [0.9, 0.6]]
    found = [
        matcher.match(one, np.array([overlap]), one == 0, np.array([5, 9]), np.zeros((2, 5))).actor_row.tolist()
        for overlap in overlaps
    ]
    assert found == [[0, -1], [-1, 0], [-1, 0]]


@pytest.mark.parametrize(("offset_m", "actor"), [(3.7, 0), (3.8, -1)])
def test_track_follows_an_actor_with_at_least_a_tenth_of_overlap(offset_m, actor):
    # Overlaps of 0.9 m / 8.3 m = 0.108 and 0.8 m / 8.4 m = 0.095.
    _, tables, grades = grade_run(ONE_CAR, Scripted([[follow(body, x=body.x + offset_m)] for (body,) in ONE_CAR]))
    assert grades[-1].track_actor.tolist() == [actor]
    assert set(tables["tracks"].verdict) == {"graded" if actor == 0 else "false"}


def test_metrics_without_vehicles_and_tracks_are_none_with_a_reason():
    metrics, tables, _ = grade_run([], Scripted([]))
    assert set(metrics) == set(STANDARD) & set(GRADED)
    found = [metrics[name] for name in GRADED]
    assert all(metric.value is None and metric.reason and metric.n == 0 for metric in found)
    assert all(len(table) == 0 and "frame" in table for table in tables.values())


def test_tracker_without_reported_tracks_has_scores_of_zero():
    metrics = run(TWO_CARS, [[] for _ in TWO_CARS])
    assert values(metrics, "hota", "mota", "idf1", "missed") == [0, 0, 0, 2 * FRAMES]
    assert metrics["track.false"].value is None
    assert "no track" in metrics["track.false"].reason


def test_heading_error_is_modulo_a_full_turn_on_moving_vehicles():
    scene = [[car(0, i, 5.0), Body(1, 0.0, -5.0)] for i in range(FRAMES)]
    script = [[follow(a, heading=math.radians(170.0)), follow(b, heading=math.pi)] for a, b in scene]
    metrics, _, grades = grade_run(scene, Scripted(script))
    assert values(metrics, "heading_abs_mean_deg", "heading_flip_rate") == pytest.approx([170.0, 1.0])
    assert metrics["track.heading_flip_rate"].n == FRAMES
    np.testing.assert_allclose(np.degrees(grades[0].track_heading_error), [170.0, 180.0])


@given(st.integers(0, 4), st.integers(0, 4), st.integers(0, 2**32 - 1))
def test_matching_is_optimal(actors, tracks, seed):
    rng = np.random.default_rng(seed)

    def boxes(n):
        return np.column_stack([rng.uniform(-3, 3, (n, 2)), rng.uniform(-3, 3, n), np.full((n, 2), (4.5, 1.8))])

    truth, seen = boxes(actors), boxes(tracks)
    config = GradingConfig()
    graded, table = np.ones(actors, bool), iou_table(truth, seen)
    matching = TrackMatcher(config).match(np.arange(actors), table, graded, np.arange(tracks), seen)
    overlap = np.array([[naive.iou(a, b) for b in seen] for a in truth]).reshape(actors, tracks)
    score = np.where(overlap >= config.match_iou_min, overlap, 0.0)
    expected = sum(score[row, column] for row, column in naive.best_pairing(score))
    pairs = [(row, column) for column, row in enumerate(matching.actor_row) if row >= 0]
    assert sum(score[row, column] for row, column in pairs) == pytest.approx(expected, abs=1e-6)
    assert all(overlap[pair] >= config.match_iou_min - 1e-6 for pair in pairs)


def test_odometry_drift_and_ego_motion_do_not_count_as_tracker_errors():
    scene = [[car(0, i, 5.0), Body(1, 12.0, -5.0, 2.0, 3.0)] for i in range(FRAMES)]

    def ego(i):
        return (2.0 * i, -0.5 * i, 0.1 * i), (1.7 * i + 0.3, 0.4 * i, -0.2 * i + 1.0)

    metrics, tables, _ = grade_run(scene, Perfect(), ego=ego)
    assert values(metrics, "hota", "heading_abs_mean_deg") == pytest.approx([1.0, 0.0], abs=1e-9)
    assert values(metrics, "velocity_abs_mean_mps", "gospa_m") == pytest.approx([0.0, 0.0], abs=1e-9)
    assert metrics["mma.x_abs_mean_m{target=moving}"].value == pytest.approx(0.0, abs=1e-9)
    both = tables["tracks"].merge(tables["truth"], on=["frame", "actor_id"], suffixes=("", "_true"))
    for column in ("x_world_m", "y_world_m"):
        np.testing.assert_allclose(both[column], both[f"{column}_true"], atol=1e-9)
