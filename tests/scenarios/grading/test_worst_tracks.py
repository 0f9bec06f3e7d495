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
        ("moving_velocity_abs_mean_mps", 1, "track 0 on vehicle car0 (cv, truly cv): velocity error 5 m/s"),
        ("moving_velocity_abs_mean_mps{class=car}", 1, "track 0 on vehicle car0 (cv, truly cv): velocity error 5 m/s"),
        ("velocity_abs_mean_mps", 2, "track 1 on vehicle car1 (cv, truly stationary): velocity error 9 m/s"),
        ("standing_speed_mean_mps", 2, "track 1 on vehicle car1 (cv, truly stationary): speed 9 m/s"),
        ("acceleration_abs_mean_mps2", 1, "track 0 on vehicle car0 (cv, truly cv): acceleration error 2 m/s^2"),
        ("length_mean_m", 0, "track 1 on vehicle car1 (cv, truly stationary): length error -0.6 m"),
        ("width_abs_mean_m{range=0-15}", 2, "track 0 on vehicle car0 (cv, truly cv): width error 0.2 m"),
        ("missed_share{actor=car1}", 3, "vehicle car1 (20 points, 21 m): time without hit 0.08 s"),
        ("mota", 3, "no track overlaps vehicle car0; no track overlaps vehicle car1"),
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


def test_a_miss_states_the_overlap_that_a_hit_needs():
    """The track is 2.5 m behind a car of 5 m: they overlap by a third."""
    scene = [[MOVING, PARKED]] * 2
    behind = follow(MOVING, x=MOVING.x - 0.5 * MOVING.size[0])
    metrics, tables, _ = grade_run(scene, Scripted([[follow(MOVING), follow(PARKED)], [behind, follow(PARKED)]]))
    result = replace(short_run.result(), metrics=metrics, tables=tables)
    for metric in ("track.hota", "track.missed", "track.gospa_m"):
        (found,) = worst_frames(result, metric)
        assert (found.frame, found.what) == (1, "track 0 overlaps vehicle car0 by 0.33, a hit needs 0.5")
