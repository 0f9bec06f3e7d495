"""Preprocessing of beams with several echoes and flags."""

import numpy as np
import pytest

from luxloop.tracker.detection.preprocess import PreprocessConfig, keep
from luxloop.tracker.scan import PointFlag, Scan

BEAM = np.array([1.0, 0.0, 0.01])


def beams(*echoes_of):
    """A scan of beams, each the (range, flags, pulse width) of its echoes, from the ego's centre at 0.6 m of height."""
    points, time, echo, flags, width = [], [], [], [], []
    for number, echoes in enumerate(echoes_of):
        direction = BEAM + np.array([0.0, 0.01 * number, 0.0])
        points += [(0.0, 0.0, 0.6) + range_m * direction / np.linalg.norm(direction) for range_m, *_ in echoes]
        time += [1e-4 * number] * len(echoes)
        echo += range(len(echoes))
        flags += [flag for _, flag, *_ in echoes]
        width += [rest[0] if rest else 1.0 for _, _, *rest in echoes]
    count = len(points)
    return Scan(
        time=0.0,
        ego_pose_odom=np.zeros(3),
        points_ego=np.array(points, np.float32).reshape(-1, 3),
        time_offset=np.array(time, np.float32),
        unit=np.zeros(count, np.uint8),
        layer=np.zeros(count, np.uint8),
        echo=np.array(echo, np.uint8),
        echo_pulse_width=np.array(width, np.float32),
        flags=np.array(flags, np.uint16),
    )


def kept(*echoes_of, **config):
    return keep(beams(*echoes_of), PreprocessConfig(**config)).tolist()


THROUGH = PointFlag.TRANSPARENT


def test_a_bumper_is_kept_and_the_window_behind_it_is_dropped():
    assert kept([(15.0, THROUGH), (16.5, 0)]) == [True, False]
    assert kept([(15.0, THROUGH), (16.5, 0)], inside_depth_m=0.0) == [True, True]
    assert kept([(15.0, THROUGH), (16.5, 0)], drop_flags=("transparent",)) == [False, True]  # as ibeo_core does


def test_an_edge_and_a_wall_far_behind_it_are_kept():
    assert kept([(15.0, THROUGH), (25.0, 0)]) == [True, True]


def test_a_vehicle_behind_rain_or_ground_echoes_is_kept():
    assert kept([(14.0, THROUGH | PointFlag.CLUTTER), (15.0, 0)]) == [False, True]
    low = beams([(14.0, THROUGH), (15.0, 0)])
    low.points_ego[:, 2] = 0.05, 0.3
    assert keep(low, PreprocessConfig()).tolist() == [False, True]


def test_a_vehicle_behind_spray_without_a_clutter_flag_is_kept():
    """Its echo is wider; an echo through a window is narrower."""
    assert kept([(14.0, THROUGH, 0.7), (15.0, 0, 1.1)]) == [True, True]
    assert kept([(14.0, THROUGH, 1.1), (15.0, 0, 0.7)]) == [True, False]


def test_a_third_echo_is_compared_with_the_second():
    assert kept([(15.0, THROUGH), (30.0, THROUGH), (31.5, 0)]) == [True, True, False]


def test_echoes_of_different_beams_are_independent():
    """A later echo may be the first of its beam in the scan, if a filter before the tracker dropped the first."""
    scan = beams([(15.0, 0)], [(16.0, 0)])
    scan.echo[1] = 1
    assert keep(scan, PreprocessConfig()).all()


def test_points_at_infinity_are_dropped_without_a_warning():
    scan = beams([(15.0, THROUGH), (16.0, 0)])
    scan.points_ego[1] = np.inf
    assert keep(scan, PreprocessConfig()).tolist() == [True, False]


def test_a_negative_depth_is_rejected():
    with pytest.raises(ValueError, match="inside_depth_m"):
        PreprocessConfig(inside_depth_m=-1.0)


def upright(*points, **config):
    """Mask of the points to keep of a scan of points (x, y, z)."""
    return keep(Scan.from_points(0.0, points), PreprocessConfig(**config)).tolist()


def test_low_points_below_a_higher_one_are_kept():
    """A car 40 m ahead while the ego accelerates by 4 m/s^2: 40 tan(0.815 deg) = 0.57 m lower than on a level ego."""
    bumper, hatch = (40.0, 0.0, 0.5 - 0.57), (40.2, 0.0, 1.1 - 0.57)
    assert upright(bumper, hatch) == [True, True]
    assert upright(bumper, hatch, upright_m=0.0) == [False, True]


def test_low_points_without_a_higher_one_near_are_ground():
    ground, ahead, car = (35.0, 1.0, 0.05), (39.6, 0.0, 0.05), (40.0, 0.0, 0.6)
    assert upright(ground, ahead, car) == [False, False, True]
    assert upright(ground, (35.2, 1.0, 0.1)) == [False, False]


def test_points_that_are_dropped_hold_no_low_ones():
    """The higher echo is from the air, out of range, or on the ego."""
    scan = Scan.from_points(0.0, [(30.0, 0.0, 0.0), (30.2, 0.0, 0.8)], flags=[0, PointFlag.CLUTTER])
    assert keep(scan, PreprocessConfig()).tolist() == [False, False]
    assert upright((59.9, 0.0, 0.0), (60.2, 0.0, 0.8)) == [False, False]
    assert upright((0.0, 1.2, 0.0), (0.0, 1.0, 0.8)) == [False, False]


def test_a_negative_distance_of_upright_points_is_refused():
    with pytest.raises(ValueError, match=r"upright_m is -0\.1; give a distance"):
        PreprocessConfig(upright_m=-0.1)
