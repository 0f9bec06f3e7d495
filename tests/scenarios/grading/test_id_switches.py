"""Id switches: the same number as in CLEAR, and those with the vehicle in view."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.frames import Body, Scripted, follow, grade_run
from support.optional import need
from support.sequences import random_sequence

from luxloop.scenarios.grading.clear_table import clear_hits, id_switches

VISIBLE = 1.0


def counts(track_ids, visible=(), points=(), absent=()):
    """Id switches, and those in view, of one car, given the id of its track in each frame (None for no track)."""
    scene, script = [], []
    for i, track in enumerate(track_ids):
        seen = dict(enumerate(visible)).get(i, VISIBLE)
        body = Body(0, 12.0, 4.0, visible=seen, points=dict(enumerate(points)).get(i, 20 if seen > 0.1 else 0))
        scene.append([] if i in absent else [body])
        script.append([] if track is None or i in absent else [follow(body, track_id=track)])
    metrics = grade_run(scene, Scripted(script))[0]
    return metrics["track.id_switches"].value, metrics["track.id_switches_in_view"].value


def test_switch_in_view_counts_also_after_frames_without_track():
    assert counts([4] * 6 + [9] * 6) == (1, 1)
    assert counts([4] * 4 + [None] * 4 + [9] * 4) == (1, 1)
    assert counts([4] * 3 + [9] * 3 + [4] * 6) == (2, 2)
    assert counts([4] * 12) == (0, 0)


def test_full_occlusion_before_the_new_track_excuses_the_switch():
    hidden = [1.0] * 4 + [0.05] * 2 + [1.0] * 6
    assert counts([4] * 4 + [None] * 2 + [9] * 6, hidden) == (1, 0)
    assert counts([4] * 4 + [None] * 5 + [9] * 3, hidden) == (1, 0)


def test_partial_or_earlier_occlusion_does_not_excuse_the_switch():
    partly = [1.0] * 4 + [0.3] * 2 + [1.0] * 6
    assert counts([4] * 4 + [None] * 2 + [9] * 6, partly, points=[20] * 4 + [5] * 2 + [20] * 6) == (1, 1)
    long_ago = [1.0] * 2 + [0.0] * 2 + [1.0] * 8
    assert counts([4] * 2 + [None] * 2 + [4] * 4 + [9] * 4, long_ago) == (1, 1)


def test_absent_vehicle_was_not_in_view():
    assert counts([4] * 4 + [None] * 2 + [9] * 6, absent=(4, 5)) == (1, 0)


def test_without_vehicles_the_metric_has_a_reason():
    metric = grade_run([], Scripted([]))[0]["track.id_switches_in_view"]
    assert (metric.value, metric.reason) == (None, "no vehicle was graded")


@given(st.integers(0, 2**32 - 1), st.integers(0, 4), st.integers(0, 4))
def test_number_of_switches_equals_trackevals(seed, vehicles, tracks):
    """Random overlaps with vehicles and tracks that come and go."""
    need("dev", "trackeval")
    from trackeval.metrics import CLEAR

    data = random_sequence(seed, vehicles, tracks)
    expected = CLEAR({"THRESHOLD": 0.5, "PRINT_CONFIG": False}).eval_sequence(data)["IDSW"]
    assert len(id_switches(data["num_gt_ids"], clear_hits(data, 0.5))) == expected


@pytest.mark.parametrize(("overlap", "found"), [(0.5, 1), (0.49, 0)])
def test_overlap_at_the_limit_is_a_hit_and_switches_have_their_steps(overlap, found):
    steps = [np.array([[1.0]]), np.empty((1, 0)), np.array([[overlap]])]
    data = {
        "num_timesteps": 3,
        "num_gt_ids": 1,
        "gt_ids": [np.array([0])] * 3,
        "tracker_ids": [np.array([0]), np.empty(0, int), np.array([1])],
        "similarity_scores": steps,
    }
    assert id_switches(1, clear_hits(data, 0.5)) == [(0, 0, 2)] * found
