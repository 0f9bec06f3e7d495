"""Scans made from plain arrays."""

from dataclasses import replace

import numpy as np
import pytest

from luxloop.tracker.scan import COLUMNS, PointFlag, Scan

POINTS = [[5.0, 1.0, 0.5], [6.0, 1.0, 0.5]]


def test_defaults_are_first_echoes_of_one_unit_on_a_stationary_ego():
    scan = Scan.from_points(3, POINTS)
    assert (scan.time, scan.ego_pose_odom.tolist(), len(scan)) == (3.0, [0.0, 0.0, 0.0], 2)
    assert scan.points_ego.tolist() == POINTS
    for name, dtype in COLUMNS.items():
        assert getattr(scan, name).dtype == dtype
        assert getattr(scan, name).tolist() == [0, 0]


def test_columns_are_converted_and_a_single_value_applies_to_all_points():
    scan = Scan.from_points(
        0.0, POINTS, [1, 2, 0.5], layer=[0.0, 3.0], unit=2, flags=PointFlag.GROUND, time_offset=[0, 1]
    )
    assert scan.layer.tolist() == [0, 3]
    assert scan.unit.tolist() == [2, 2]
    assert scan.flags.tolist() == [PointFlag.GROUND, PointFlag.GROUND]
    assert scan.time_offset.tolist() == [0.0, 1.0]
    assert [getattr(scan, name).dtype for name in COLUMNS] == list(COLUMNS.values())
    assert scan.ego_pose_odom.dtype == np.float64


def test_a_scan_copies_its_arrays():
    """Later changes of the caller's arrays must not affect the tracker, which stores the last pose."""
    points, pose, unit = np.ones((2, 3), np.float32), np.zeros(3), np.zeros(2, np.uint8)
    scan = Scan.from_points(0.0, points, pose, unit=unit)
    points[0], pose[0], unit[0] = 9.0, 5.0, 7
    assert (scan.points_ego == 1.0).all()
    assert scan.ego_pose_odom[0] == 0.0
    assert scan.unit[0] == 0


@pytest.mark.parametrize("nothing", [[], np.empty((0, 3)), ()])
def test_no_points(nothing):
    assert Scan.from_points(0.0, nothing).points_ego.shape == (0, 3)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"points_ego": [[1.0, 2.0]]}, r"points_ego is float32 \(1, 2\); give an array \(1, 3\) of floats"),
        ({"points_ego": 3.0}, "points_ego is"),
        ({"ego_pose_odom": [1.0, 2.0]}, r"ego_pose_odom is float64 \(2,\)"),
        ({"ego_pose_odom": [1.0, 2.0, np.nan]}, "ego_pose_odom at 0.0 s is"),
        ({"time": np.inf}, "time is inf"),
        ({"time_offset": [0.0]}, r"time_offset has shape \(1,\); give one value, or one for each of the 2 points"),
        ({"layer": 0.5}, "layer holds values outside uint8; give whole numbers from 0 to 255"),
        ({"unit": [0, 256]}, "unit holds values outside uint8"),
        ({"echo": np.nan}, "echo holds values outside uint8"),
        ({"flags": -1}, "flags holds values outside uint16; give whole numbers from 0 to 65535"),
    ],
)
def test_invalid_values_raise_a_named_error(values, message):
    with pytest.raises(ValueError, match=message):
        Scan.from_points(**{"time": 0.0, "points_ego": POINTS, **values})


def limited(limits, **columns):
    """Return a scan with fields of view."""
    return replace(Scan.from_points(0.0, POINTS, **columns), sweep_limits=limits)


def test_fields_of_view_are_unknown_by_default():
    assert Scan.from_points(0.0, POINTS).sweep_limits is None


def test_fields_of_view_may_have_more_units_and_layers_than_the_points():
    limited(np.zeros((6, 4, 2), np.float32), unit=[0, 5], layer=3).check()
    limited(np.full((1, 1, 2), np.nan, np.float32)).check()


@pytest.mark.parametrize(
    ("limits", "columns", "message"),
    [
        (np.zeros((2, 4, 2)), {"unit": 2}, "sweep_limits has 2 units and a point is of unit 2; give the limits of all"),
        (np.zeros((2, 4, 2)), {"layer": [0, 4]}, "sweep_limits has 4 layers and a point is of layer 4"),
        (np.zeros((1, 1, 3)), {}, r"sweep_limits is float64 \(1, 1, 3\); give an array \(1, 1, 2\) of floats"),
        (np.zeros((1, 2)), {}, "sweep_limits is float64"),
        (np.zeros((1, 1, 2), np.int64), {}, "sweep_limits is int64"),
        ([[[0.0, 1.0]]], {}, "sweep_limits is list"),
    ],
)
def test_invalid_fields_of_view_raise_a_named_error(limits, columns, message):
    with pytest.raises(ValueError, match=message):
        limited(limits, **columns).check()


@pytest.mark.parametrize(
    ("positions", "message"),
    [
        (np.zeros((2, 2)), "unit_positions_ego has 2 units and a point is of unit 2; give the positions of all units"),
        (np.zeros((3, 3)), r"unit_positions_ego is float64 \(3, 3\); give an array \(3, 2\) of floats"),
        (np.full((3, 2), np.nan), "unit_positions_ego has a value that is not finite"),
        ([[0.0, 0.0]] * 3, "unit_positions_ego is list"),
    ],
)
def test_invalid_unit_positions_raise_a_named_error(positions, message):
    scan = Scan.from_points(0.0, POINTS, unit=2)
    assert scan.unit_positions_ego is None
    replace(scan, unit_positions_ego=np.zeros((3, 2))).check()
    with pytest.raises(ValueError, match=message):
        replace(scan, unit_positions_ego=positions).check()
