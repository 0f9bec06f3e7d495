"""Errors of velocity, acceleration, size and heading of tracks, by hand."""

import math

import pytest
from support.frames import Body, Scripted, follow, grade_run

from luxloop.sensor_model.truth import View
from luxloop.sim.world import Kind, Mode

MOVING = Body(0, 10.0, 5.0, 0.0, 10.0)
PARKED = Body(1, 20.0, -5.0)


def metrics_of(bodies, estimates, **options):
    return grade_run([bodies], Scripted([estimates]), **options)[0]


def values(metrics, *names):
    return [metrics[f"track.{name}"].value for name in names]


def test_velocity_errors_of_moving_and_standing_vehicles():
    """The moving car is off by (3, 4) m/s, and its speed by 13.60 - 10; the parked one moves at 0.5 m/s."""
    metrics = metrics_of([MOVING, PARKED], [follow(MOVING, velocity=(13.0, 4.0)), follow(PARKED, velocity=(0.3, 0.4))])
    assert values(metrics, "moving_velocity_abs_mean_mps", "standing_speed_mean_mps") == pytest.approx([5.0, 0.5])
    assert values(metrics, "velocity_abs_mean_mps") == pytest.approx([2.75])
    faster = math.hypot(13.0, 4.0) - 10.0
    assert values(metrics, "speed_mean_mps", "speed_abs_mean_mps") == pytest.approx([(faster + 0.5) / 2] * 2)


def test_velocity_is_compared_at_the_tracked_corner():
    """The front left corner of a car that turns about its centre at 0.5 rad/s moves by 0.5 (-0.9, 2.3) m/s."""
    turning = Body(0, 10.0, 5.0, 0.0, 5.0, Mode.ACCELERATING, yaw_rate=0.5, acceleration=(1.0, 2.0))
    corner = (5.0 - 0.45, 1.15)
    # Towards the centre by w^2 r.
    acceleration = (1.0 - 0.25 * 2.3, 2.0 - 0.25 * 0.9)
    metrics = metrics_of([turning], [follow(turning, velocity=corner, acceleration=acceleration)])
    assert values(metrics, "moving_velocity_abs_mean_mps", "acceleration_abs_mean_mps2") == pytest.approx(
        [0.0, 0.0], abs=1e-12
    )
    metrics = metrics_of([turning], [follow(turning)])
    assert values(metrics, "moving_velocity_abs_mean_mps") == pytest.approx([0.5 * math.hypot(0.9, 2.3)])


def test_the_frame_of_the_odometry_does_not_matter():
    """The ego's odometry is turned by 90 degrees: a velocity along world x is one along odometry y."""
    estimate = follow(MOVING, x=-5.0, y=10.0, heading=math.pi / 2, velocity=(0.0, 10.0))
    metrics = metrics_of([MOVING], [estimate], ego=lambda _: ((0.0, 0.0, 0.0), (0.0, 0.0, math.pi / 2)))
    assert values(metrics, "velocity_abs_mean_mps", "heading_abs_mean_deg") == pytest.approx([0.0, 0.0], abs=1e-9)


def test_acceleration_is_that_of_moving_vehicles():
    metrics = metrics_of([MOVING, PARKED], [follow(MOVING, acceleration=(0.6, 0.8)), follow(PARKED)])
    assert values(metrics, "acceleration_abs_mean_mps2") == pytest.approx([1.0])
    assert metrics["track.acceleration_abs_mean_mps2"].n == 1


def test_size_errors_have_signs_and_means_of_absolutes():
    estimates = [follow(MOVING, size=(5.0, 1.7)), follow(PARKED, size=(4.0, 1.7))]
    metrics = metrics_of([MOVING, PARKED], estimates)
    assert values(metrics, "length_mean_m", "length_abs_mean_m") == pytest.approx([-0.1, 0.5])
    assert values(metrics, "width_mean_m", "width_abs_mean_m") == pytest.approx([-0.1, 0.1])


def test_headings_of_standing_vehicles_are_modulo_180_degrees():
    turned = follow(PARKED, heading=math.radians(170.0))
    metrics = metrics_of([MOVING, PARKED], [follow(MOVING, heading=math.radians(-20.0)), turned])
    names = ("standing_heading_abs_mean_deg", "heading_abs_mean_deg", "heading_abs_p90_deg", "heading_flip_rate")
    assert values(metrics, *names) == pytest.approx([10.0, 20.0, 20.0, 0.0])


def test_backward_headings_are_told_apart_by_motion_in_sight():
    """The car stands for 4 frames, moves for 3 and stands for 3; its track faces backwards in frames 0, 5, 8 and 9."""
    speed = [0.0] * 4 + [5.0] * 3 + [0.0] * 3
    backwards = {0: math.pi, 5: math.pi, 8: math.radians(91.0), 9: math.radians(-91.0)}
    script = [[follow(PARKED, heading=backwards.get(i, math.radians(89.0)))] for i in range(10)]
    metrics = grade_run([[Body(1, 20.0, -5.0, 0.0, v)] for v in speed], Scripted(script))[0]
    names = ("parked_flip_rate", "stopped_flip_rate", "standing_flip_rate")
    assert values(metrics, *names) == pytest.approx([1 / 4, 2 / 3, 3 / 7])
    assert [metrics[f"track.{name}"].n for name in names] == [4, 3, 7]


def test_the_90th_percentile_is_that_of_all_frames():
    script = [[follow(MOVING, heading=math.radians(float(i)))] for i in range(11)]
    metrics = grade_run([[MOVING]] * 11, Scripted(script))[0]
    assert values(metrics, "heading_abs_p90_deg", "heading_abs_mean_deg") == pytest.approx([9.0, 5.0])


def test_bands_have_their_own_means():
    truck = Body(2, 40.0, 0.0, 0.0, 20.0, size=(9.0, 2.5, 3.0), kind=Kind.TRUCK, view=View.SIDE)
    metrics = metrics_of([MOVING, truck], [follow(MOVING, velocity=(11.0, 0.0)), follow(truck, size=(8.0, 2.5))])
    bands = ("range=0-15", "class=car", "view=l_shape")
    for band in bands:
        assert values(metrics, f"moving_velocity_abs_mean_mps{{{band}}}", f"length_mean_m{{{band}}}") == [1.0, 0.0]
    for band in ("range=30-50", "class=truck", "view=side"):
        assert values(metrics, f"moving_velocity_abs_mean_mps{{{band}}}", f"length_mean_m{{{band}}}") == [0.0, -1.0]
    missing = metrics["track.standing_speed_mean_mps{class=car}"]
    assert missing.value is None
    assert missing.reason == "no confirmed track followed a graded vehicle that was standing, with class car"


def test_unknown_velocities_do_not_count():
    metrics = metrics_of([MOVING, PARKED], [follow(MOVING, velocity=(math.nan, 0.0)), follow(PARKED)])
    assert (metrics["track.velocity_abs_mean_mps"].value, metrics["track.velocity_abs_mean_mps"].n) == (0.0, 1)
    assert "does not report" in metrics["track.moving_velocity_abs_mean_mps"].reason
