"""Prediction errors of scripted trackers, computed by hand."""

from dataclasses import replace

import numpy as np
import pytest
from support import short_run
from support.frames import DT, Body, Scripted, drive, follow, grade_run, tracks_of

from luxloop.scenarios.grading import mma_metrics
from luxloop.scenarios.grading.worst_frames import worst_frames
from luxloop.scenarios.metrics.definitions import HORIZONS
from luxloop.sim.world import Mode
from luxloop.tracker.records import MODELS, PREDICTION_S

SPEED = 5.0


class Predicting(Scripted):
    """Tracker with perfect tracks, whose models predict a straight motion along x at given speeds."""

    speeds = (0.0, SPEED, SPEED + 1.0, SPEED - 0.5)
    """Of stationary, cv, ca, and of the reported estimate [m/s]."""

    def step(self, _):
        self.index += 1
        tracks = tracks_of(self.script[self.index])
        way = np.outer(self.speeds, PREDICTION_S)
        ahead = np.stack([way, 0.0 * way], axis=-1)
        return replace(tracks, prediction_odom=tracks.mean[:, None, None, :2] + ahead), None


def scene(frames=60, change=None):
    """A car that drives along x; from frame `change` on its true mode is accelerating."""
    modes = [Mode.ACCELERATING if change is not None and i >= change else Mode.CONSTANT_VELOCITY for i in range(frames)]
    return [[Body(0, *drive(12.0, 4.0, 0.0, SPEED, i), 0.0, SPEED, mode=modes[i])] for i in range(frames)]


def graded(bodies, tracker=Predicting, **changes):
    script = [[follow(body, **changes) for body in frame] for frame in bodies]
    return grade_run(bodies, tracker(script))[0]


def test_error_is_the_distance_at_the_time_of_the_prediction():
    metrics = graded(scene())
    for label, seconds in HORIZONS.items():
        off = {"stationary": SPEED, "cv": 0.0, "ca": 1.0, "mma": 0.5}
        for estimate, speed in off.items():
            found = metrics[f"mma.prediction_{label}_abs_mean_m{{model={estimate}}}"]
            assert found.value == pytest.approx(speed * seconds, abs=1e-6)
            # 60 frames at 0.08 s; the last frame must not be earlier than the time of the prediction.
            assert found.n == sum(i * DT + seconds <= 59 * DT + 1e-9 for i in range(60))


def test_the_error_now_is_a_part_of_the_error_ahead():
    bodies = scene()
    shifted = [[replace(follow(body), x=body.x + 0.3, y=body.y + 0.4) for body in frame] for frame in bodies]
    metrics = grade_run(bodies, Predicting(shifted))[0]
    assert metrics["mma.prediction_1s_abs_mean_m{model=cv}"].value == pytest.approx(0.5)


@pytest.mark.parametrize("corner", [(1, 1), (-1, 1), (1, -1)])
def test_any_corner_of_a_turned_track_is_compared_with_itself(corner):
    """The track takes the rear as front; its corner is still one of the vehicle."""
    metrics = graded(scene(), heading=np.pi, corner=corner)
    assert metrics["mma.prediction_2s_abs_mean_m{model=cv}"].value == pytest.approx(0.0, abs=1e-6)


def test_ego_motion_and_odometry_do_not_enter():
    """The ego turns and moves, and its odometry starts elsewhere; perfect tracks remain perfect."""

    def ego(index):
        world = np.array([0.2 * index, -0.1 * index, 0.01 * index])
        return tuple(world), tuple(world + np.array([100.0, -50.0, 0.0]))

    bodies = scene()
    script = [[replace(follow(body), x=body.x + 100.0, y=body.y - 50.0) for body in frame] for frame in bodies]
    metrics = grade_run(bodies, Predicting(script), ego=ego)[0]
    assert metrics["mma.prediction_1s_abs_mean_m{model=cv}"].value == pytest.approx(0.0, abs=1e-6)


def test_frames_around_a_change_of_mode_are_those_within_a_second():
    metrics = graded(scene(frames=80, change=30))
    # |i - 30| x 0.08 <= 1 s: 12 frames before and after, and the change itself.
    assert metrics["mma.prediction_1s_abs_mean_m{model=cv,when=changing}"].n == 25
    assert metrics["mma.prediction_1s_abs_mean_m{model=ca,when=changing}"].value == pytest.approx(1.0)
    none = graded(scene())["mma.prediction_1s_abs_mean_m{model=cv,when=changing}"]
    assert (none.value, none.n) == (None, 0)


def test_a_bank_with_a_turning_model_has_metrics_of_it_and_null_ones_of_missing_models():
    """cv and ctra; a ctra that is selected describes an accelerating vehicle."""

    class Turning(Predicting):
        speeds = (SPEED, SPEED + 2.0, SPEED)

        def step(self, _):
            self.index += 1
            tracks = tracks_of(self.script[self.index])
            ahead = np.stack([np.outer(self.speeds, PREDICTION_S), np.zeros((3, 3))], axis=-1)
            return replace(
                tracks,
                models=("cv", "ctra"),
                model_probability=np.tile([0.4, 0.6], (len(tracks), 1)),
                model=np.ones(len(tracks), np.int64),
                model_position_odom=np.repeat(tracks.mean[:, None, :2], 2, axis=1),
                prediction_odom=tracks.mean[:, None, None, :2] + ahead,
            ), None

    bodies = scene(change=0)
    metrics, tables, _ = grade_run(bodies, Turning([[follow(body) for body in frame] for frame in bodies]))
    assert metrics["mma.prediction_1s_abs_mean_m{model=ctra}"].value == pytest.approx(2.0)
    assert metrics["mma.x_abs_mean_m{model=ctra,target=moving}"].value == pytest.approx(0.0, abs=1e-9)
    assert metrics["mma.mode_accuracy"].value == 1.0
    assert metrics["mma.selected{mode=ca,model=ctra}"].value == 1.0
    assert metrics["mma.gain{target=moving}"].n == len(bodies)
    assert metrics["mma.prediction_1s_abs_mean_m{model=stationary}"].value is None
    assert metrics["mma.prediction_1s_abs_mean_m{model=ctrv}"].reason == "the run's filter bank has no such model"
    assert "mma.nees_mean{model=ctrv}" not in list(metrics)
    assert set(tables["tracks"]["model"]) == {"ctra"}
    assert (tables["tracks"]["probability_ctra"] == 0.6).all()


def test_a_tracker_without_predictions_has_null_metrics_with_a_reason():
    metrics = graded(scene(), tracker=Scripted)
    for estimate in (*MODELS, "mma"):
        found = metrics[f"mma.prediction_1s_abs_mean_m{{model={estimate}}}"]
        assert found.value is None
        assert found.reason == "the tracker does not report predictions"


def test_the_worst_frame_is_that_of_the_largest_error():
    """The prediction of frame 7 has an error of 3 m, the others have none."""

    class OnceWrong(Predicting):
        speeds = (SPEED,) * 4

        def step(self, scan):
            tracks, trace = super().step(scan)
            if self.index == 7:
                tracks.prediction_odom[:, -1, :, 1] += 3.0
            return tracks, trace

    bodies = scene(change=40)
    metrics, tables, _ = grade_run(bodies, OnceWrong([[follow(body) for body in frame] for frame in bodies]))
    result = replace(short_run.result(), metrics=metrics, tables=tables)
    worst = worst_frames(result, "mma.prediction_1s_abs_mean_m", count=1)
    assert [found.frame for found in worst] == [7]
    assert worst[0].what == "track 0 on vehicle car0 (cv, truly cv): mma ahead 1s error 3 m"
    changing = worst_frames(result, "mma.prediction_1s_abs_mean_m{when=changing}", count=1)
    assert changing[0].frame >= 28


def test_truth_is_interpolated_between_successive_frames_only():
    """A vehicle that is absent in frame 3 has no pose between frames 2 and 4; a yaw is interpolated over the cut."""
    frame, time = np.array([0.0, 1.0, 2.0, 4.0, 5.0]), np.array([0.0, 0.1, 0.2, 0.4, 0.5])
    pose = np.column_stack([[0.0, 1.0, 2.0, 4.0, 5.0], np.zeros(5), [3.1, -3.1, 0.0, 0.0, 0.0]])
    found = mma_metrics.interpolated(time, frame, pose, np.array([0.05, 0.1, 0.3, 0.45, 0.6]))
    assert found[[0, 1, 3], 0] == pytest.approx([0.5, 1.0, 4.5])
    assert abs(found[0, 2]) == pytest.approx(np.pi)
    assert np.isnan(found[[2, 4]]).all()
    assert np.isnan(mma_metrics.interpolated(time[:1], frame[:1], pose[:1], np.array([0.05]))).all()
