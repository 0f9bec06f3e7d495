"""Worst frames of the estimates of tracks, from graded scenes."""

from dataclasses import replace

import pytest
from support import short_run
from support.frames import Body, Scripted, follow, grade_run

from luxloop.scenarios.grading.worst_frames import worst_frames

MOVING, PARKED = Body(0, 10.0, 5.0, 0.0, 10.0), Body(1, 20.0, -5.0)


@pytest.mark.parametrize(
    ("metric", "frame", "what"),
    [
        ("moving_velocity_abs_mean_mps", 1, "track 0 on vehicle car0 is +5.00 m/s off in its velocity"),
        ("moving_velocity_abs_mean_mps{class=car}", 1, "track 0 on vehicle car0 is +5.00 m/s off in its velocity"),
        ("velocity_abs_mean_mps", 2, "track 1 on vehicle car1 is +9.00 m/s off in its velocity"),
        ("standing_speed_mean_mps", 2, "track 1 on vehicle car1 is +9.00 m/s fast"),
        ("acceleration_abs_mean_mps2", 1, "track 0 on vehicle car0 is +2.00 m/s^2 off in its acceleration"),
        ("length_mean_m", 0, "track 1 on vehicle car1 is -0.60 m off in its length"),
        ("width_abs_mean_m{range=0-15}", 2, "track 0 on vehicle car0 is +0.20 m off in its width"),
        ("missed_share{class=car}", 3, "2 graded vehicles without a track, 0 false tracks"),
        ("time_to_confirm_s", 3, "2 graded vehicles without a track, 0 false tracks"),
    ],
)
def test_the_worst_frame_has_the_largest_error(metric, frame, what):
    script = [
        [follow(MOVING), follow(PARKED, size=(4.0, 1.8))],
        [follow(MOVING, velocity=(13.0, 4.0), acceleration=(2.0, 0.0)), follow(PARKED)],
        [follow(MOVING, size=(4.6, 2.0)), follow(PARKED, velocity=(9.0, 0.0))],
        [],
    ]
    metrics, tables, _ = grade_run([[MOVING, PARKED]] * 4, Scripted(script))
    result = replace(short_run.result(), metrics=metrics, tables=tables)
    found = worst_frames(result, f"track.{metric}")[0]
    assert (found.frame, found.what) == (frame, what)
