import pytest
from support.frames import DT, Body, Scripted, follow, grade_run

from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.sim.world import Kind


def survival(visible, track_ids, config=None, points=None, name="occlusion_survival", **body):
    """Grade one car, seen by the fraction `visible` of itself in each frame and followed by `track_ids`."""
    points = points or [20 if v > 0.1 else 0 for v in visible]
    scene = [[Body(0, 12.0, 4.0, visible=v, points=p, **body)] for v, p in zip(visible, points, strict=True)]
    script = [
        [] if track is None else [follow(body, track_id=track)] for (body,), track in zip(scene, track_ids, strict=True)
    ]
    metric = grade_run(scene, Scripted(script), config=config)[0][f"track.{name}"]
    return metric.value, metric.n


def test_same_id_after_the_gap_survives_and_another_id_does_not():
    visible = [1] * 5 + [0] * 10 + [1] * 5
    assert survival(visible, [4] * 20) == (1.0, 1)
    assert survival(visible, [4] * 5 + [None] * 10 + [4] * 5) == (1.0, 1)
    assert survival(visible, [4] * 15 + [9] * 5) == (0.0, 1)
    assert survival(visible, [4] * 5 + [None] * 15) == (0.0, 1)


def test_first_track_after_the_gap_decides_even_if_late():
    visible = [1] * 5 + [0] * 10 + [1] * 10
    assert survival(visible, [4] * 5 + [None] * 13 + [4] * 7) == (1.0, 1)
    assert survival(visible, [4] * 5 + [None] * 13 + [9] * 2 + [4] * 5) == (0.0, 1)


def test_last_track_before_the_gap_decides():
    visible = [1] * 8 + [0] * 10 + [1] * 5
    assert survival(visible, [4] * 3 + [9] * 20) == (1.0, 1)
    assert survival(visible, [4] * 3 + [9] * 5 + [None] * 10 + [4] * 5) == (0.0, 1)
    assert survival(visible, [4] * 3 + [9] * 3 + [None] * 12 + [9] * 5) == (1.0, 1)


def test_two_occlusions_count_as_two():
    visible = [1] * 4 + [0] * 4 + [1] * 4 + [0] * 4 + [1] * 4
    assert survival(visible, [4] * 12 + [9] * 8) == (0.5, 2)


@pytest.mark.parametrize(("hidden_frames", "episodes"), [(36, 1), (37, 0)])
def test_only_occlusions_within_the_memory_count(hidden_frames, episodes):
    # 37 steps of 0.08 s are 2.96 s between graded frames, 38 are 3.04 s.
    assert DT == 0.08
    visible = [1] * 3 + [0] * hidden_frames + [1] * 3
    assert survival(visible, [4] * len(visible))[1] == episodes


def test_gap_without_occlusion_does_not_count():
    points = [20] * 3 + [8] * 3 + [20] * 3
    assert survival([1] * 9, [4] * 9, points=points) == (None, 0)
    assert survival([1] * 3 + [0.3] * 3 + [1] * 3, [4] * 9, points=points) == (None, 0)
    assert survival([1] * 3 + [0.1] * 3 + [1] * 3, [4] * 9, points=points) == (1.0, 1)
    # In the rig's blind spot, a car has no hits even without occluders.
    assert survival([1] * 3 + [0] * 3 + [1] * 3, [4] * 9, alone=0) == (None, 0)


def test_vehicle_never_followed_or_never_graded_does_not_count():
    visible = [1] * 3 + [0] * 3 + [1] * 3
    assert survival(visible, [None] * 6 + [4] * 3) == (None, 0)
    assert survival(visible, [4] * 9, kind=Kind.PEDESTRIAN) == (None, 0)


def test_memory_and_hidden_fraction_are_config():
    visible = [1] * 3 + [0.3] * 5 + [1] * 3
    points = [20] * 3 + [5] * 5 + [20] * 3
    assert survival(visible, [4] * 11, GradingConfig(hidden_fraction_max=0.5), points=points) == (1.0, 1)
    config = GradingConfig(hidden_fraction_max=0.5, memory_s=0.3)
    assert survival(visible, [4] * 11, config, points=points) == (None, 0)


@pytest.mark.parametrize(("hidden_frames", "episodes"), [(24, 1), (25, 0)])
def test_short_occlusions_are_those_of_two_seconds(hidden_frames, episodes):
    # 25 steps of 0.08 s are 2.00 s between graded frames, 26 are 2.08 s.
    visible = [1] * 3 + [0] * hidden_frames + [1] * 3
    assert survival(visible, [4] * len(visible), name="hidden_2s_survival")[1] == episodes
    assert survival(visible, [4] * len(visible))[1] == 1


def test_short_occlusions_have_a_separate_survival_rate():
    # The id survives an occlusion of one second, and not one of two and a half seconds.
    visible = [1] * 3 + [0] * 12 + [1] * 3 + [0] * 31 + [1] * 3
    tracks = [4] * 18 + [None] * 31 + [9] * 3
    assert survival(visible, tracks, name="hidden_2s_survival") == (1.0, 1)
    assert survival(visible, tracks) == (0.5, 2)
    metric = grade_run([], Scripted([]))[0]["track.hidden_2s_survival"]
    assert (metric.value, metric.reason) == (None, "no followed vehicle was hidden and came back within 2 s")


def test_time_and_error_of_reacquisition():
    # Graded again in frame 15 and followed from frame 18 on, 3 frames of 0.08 s later, by a track 0.5 m ahead.
    hidden, lost = range(5, 15), range(5, 18)
    scene = [[Body(0, 12.0, 4.0, visible=float(i not in hidden), points=20 * (i not in hidden))] for i in range(25)]
    ahead = [0.5 if i >= lost.stop else 0.0 for i in range(25)]
    script = [[] if i in lost else [follow(scene[i][0], track_id=4, x=12.0 + ahead[i])] for i in range(25)]
    metrics = grade_run(scene, Scripted(script))[0]
    assert metrics["track.reacquire_s"].value == pytest.approx(3 * DT)
    assert metrics["track.reappearance_error_m"].value == pytest.approx(0.5)
    assert metrics["track.occlusion_survival"].value == 1.0
