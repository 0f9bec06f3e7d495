"""PointCloud2 messages of common drivers, packed by hand."""

import warnings
from types import SimpleNamespace

import numpy as np
import pytest

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.recordings.formats.format_choice import ReadOptions
from luxloop.scenarios.recordings.formats.point_files import sweep_of_table
from luxloop.scenarios.recordings.formats.ros_topics import CLOUD, LASER, ODOMETRY, RosTopics, sweep_of

CODES = {"<f4": 7, "<f8": 8, "<u2": 4, "<u4": 6, "u1": 2}


def cloud(rows, names, formats, *, padding=0, height=1):
    """Return a PointCloud2 with `padding` bytes behind each point."""
    offsets = np.cumsum([0, *(np.dtype(kind).itemsize for kind in formats)])
    layout = np.dtype({"names": names, "formats": formats, "offsets": offsets[:-1], "itemsize": offsets[-1] + padding})
    table = np.zeros(len(rows), layout)
    for row, values in enumerate(rows):
        for name, value in zip(names, values, strict=True):
            table[name][row] = value
    fields = [
        SimpleNamespace(name=name, datatype=CODES[kind], offset=int(offset), count=1)
        for name, kind, offset in zip(names, formats, offsets, strict=False)
    ]
    width = len(rows) // height
    stamp = SimpleNamespace(sec=100, nanosec=500_000_000)
    return SimpleNamespace(
        header=SimpleNamespace(stamp=stamp, frame_id="lidar"), height=height, width=width, fields=fields,
        is_bigendian=False, point_step=layout.itemsize, row_step=layout.itemsize * width, data=table.tobytes(),
    )  # fmt: skip


def test_a_velodyne_cloud_has_rings_and_seconds():
    message = cloud([(1, 2, 3, 9, 0.25), (4, 5, 6, 8, -0.01)], ["x", "y", "z", "ring", "time"],
                    ["<f4", "<f4", "<f4", "<u2", "<f4"], padding=6)  # fmt: skip
    sweep = sweep_of(CLOUD, message, 0.0, 2)
    assert (sweep.time, sweep.unit) == (100.5, 2)
    assert sweep.points.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert sweep.ring.tolist() == [9, 8]
    assert sweep.time_offset == pytest.approx([0.25, -0.01])


def test_an_ouster_cloud_has_nanoseconds_and_zeros_for_missing_returns():
    message = cloud([(0, 0, 0, 0), (1, 1, 0, 2_000_000)], ["x", "y", "z", "t"], ["<f4", "<f4", "<f4", "<u4"])
    sweep = sweep_of(CLOUD, message, 0.0, 0)
    assert sweep.points.tolist() == [[1, 1, 0]]
    assert sweep.time_offset == pytest.approx([0.002])


def test_times_on_the_clock_become_offsets():
    clock = 1_700_000_000.0
    message = cloud([(1, 0, 0, clock + 0.05)], ["x", "y", "z", "timestamp"], ["<f4", "<f4", "<f4", "<f8"])
    message.header.stamp = SimpleNamespace(sec=int(clock), nanosec=0)
    assert sweep_of(CLOUD, message, 0.0, 0).time_offset == pytest.approx([0.05], abs=1e-6)


@pytest.mark.parametrize(
    ("kind", "times"),
    [("<f8", (0.0, 1e8)), ("<f4", (0.0, 1e5)), ("<f4", (0.0, 100.0)), ("<f4", (0.0, 0.1)), ("<u4", (0, 100_000_000))],
)
def test_the_unit_of_times_follows_from_the_length_of_the_sweep(kind, times):
    """Drivers write seconds, milliseconds, microseconds and nanoseconds under the same names."""
    message = cloud([(1, 0, 0, times[0]), (2, 0, 0, times[1])], ["x", "y", "z", "time"], ["<f4", "<f4", "<f4", kind])
    assert sweep_of(CLOUD, message, 0.0, 0).time_offset == pytest.approx([0.0, 0.1])


@pytest.mark.parametrize("since_power_on", [1000.0, 1e12, 1.7e18])
def test_times_on_another_clock_count_from_the_first_point(since_power_on):
    times = (since_power_on + 0.05, since_power_on) if since_power_on < 1e6 else (since_power_on + 5e7, since_power_on)
    rows = [(1, 0, 0, times[0]), (2, 0, 0, times[1])]
    message = cloud(rows, ["x", "y", "z", "time"], ["<f4", "<f4", "<f4", "<f8"])
    assert sweep_of(CLOUD, message, 0.0, 0).time_offset == pytest.approx([0.05, 0.0], abs=1e-6)


def test_times_of_more_than_a_sweep_are_refused():
    message = cloud([(1, 0, 0, 0.0), (2, 0, 0, 6e9)], ["x", "y", "z", "time"], ["<f4", "<f4", "<f4", "<f8"])
    with pytest.raises(InputError, match=r"field time, span 6 s .* a sweep takes at most 2 s"):
        sweep_of(CLOUD, message, 0.0, 0)


@pytest.mark.parametrize(
    ("kind", "time_unit_s", "last_s"), [("<f4", None, 1.5), ("<f4", 1e-6, 0.0015), ("<u4", 1e-6, 0.0015)]
)
def test_a_given_unit_replaces_that_of_the_length_of_the_sweep(kind, time_unit_s, last_s):
    """Some LIDARs send 500 short sweeps a second: 1500 microseconds look like milliseconds."""
    message = cloud([(1, 0, 0, 0), (2, 0, 0, 1500)], ["x", "y", "z", "time"], ["<f4", "<f4", "<f4", kind])
    assert sweep_of(CLOUD, message, 0.0, 0, time_unit_s).time_offset == pytest.approx([0.0, last_s])


def test_a_given_unit_by_which_a_sweep_is_too_long_is_refused():
    message = cloud([(1, 0, 0, 0.0), (2, 0, 0, 1e5)], ["x", "y", "z", "time"], ["<f4", "<f4", "<f4", "<f4"])
    with pytest.raises(
        InputError, match=r"field time, span 100 s in units of 0\.001 s; .*give the unit by --time-unit"
    ):
        sweep_of(CLOUD, message, 0.0, 0, 1e-3)


def test_points_without_a_time_are_left_out():
    message = cloud([(1, 0, 0, np.nan), (2, 0, 0, 0.1)], ["x", "y", "z", "time"], ["<f4", "<f4", "<f4", "<f4"])
    assert sweep_of(CLOUD, message, 0.0, 0).points[:, 0].tolist() == [2.0]
    message = cloud([(1, 0, 0, np.nan)], ["x", "y", "z", "time"], ["<f4", "<f4", "<f4", "<f4"])
    assert len(sweep_of(CLOUD, message, 0.0, 0)) == 0


def test_a_livox_message_has_nanoseconds_and_lines():
    """Fields as in livox_ros_driver2/CustomMsg; points at the origin are missing returns."""
    points = [
        SimpleNamespace(offset_time=t, x=x, y=0.5, z=0.1, reflectivity=9, tag=16, line=line)
        for t, x, line in [(0, 4.0, 0), (50_000_000, 5.0, 3)]
    ]
    message = SimpleNamespace(header=cloud([(1, 2, 3)], ["x", "y", "z"], ["<f4"] * 3).header, points=points)
    sweep = sweep_of("livox_ros_driver2/CustomMsg", message, 0.0, 1)
    assert sweep.points[:, 0].tolist() == [4.0, 5.0]
    assert sweep.time_offset == pytest.approx([0.0, 0.05])
    assert sweep.ring.tolist() == [0, 3]


def test_a_recording_of_packets_lists_its_topics_with_types():
    types = {"/packets": "velodyne_msgs/msg/VelodyneScan", "/imu": "sensor_msgs/msg/Imu"}
    listed = r"the recording has /imu \(sensor_msgs/Imu\), /packets \(velodyne_msgs/VelodyneScan\); convert packets"
    with pytest.raises(InputError, match=listed):
        RosTopics.of("drive", types, {"/packets": 3, "/imu": 9}, ReadOptions(), lambda _: [])


def test_an_organised_cloud_and_a_zero_stamp():
    message = cloud([(k, 1, 0) for k in range(1, 7)], ["x", "y", "z"], ["<f4"] * 3, height=2)
    message.header.stamp = SimpleNamespace(sec=0, nanosec=0)
    sweep = sweep_of(CLOUD, message, 42.0, 0)
    assert sweep.time == 42.0
    assert sweep.points[:, 0].tolist() == [1, 2, 3, 4, 5, 6]


def test_a_cloud_that_contradicts_itself_is_an_error():
    message = cloud([(1, 2, 3)], ["x", "y", "z"], ["<f4"] * 3)
    message.width = 2
    with pytest.raises(InputError, match="2 x 1 points"):
        sweep_of(CLOUD, message, 0.0, 0)
    with pytest.raises(InputError, match="no field z"):
        sweep_of(CLOUD, cloud([(1, 2)], ["x", "y"], ["<f4"] * 2), 0.0, 0)


# --- messages that contradict themselves: one line that names file and topic, as of every damaged message


def of_message(kind, message):
    return RosTopics("drive.bag", {"/p": kind}, {"/p": 1}, ["/p"], lambda _: [("/p", 1.0, message)], ReadOptions())


def with_fields(*fields):
    message = cloud([(1, 2, 3), (4, 5, 6)], ["x", "y", "z"], ["<f4"] * 3)
    message.fields = [SimpleNamespace(name=name, datatype=7, offset=offset, count=1) for name, offset in fields]
    return message


LASER_SCAN = SimpleNamespace(
    header=cloud([(1, 2, 3)], ["x", "y", "z"], ["<f4"] * 3).header, ranges=[1.0, 2.0], range_min=0.0, range_max=9.0,
    angle_min=np.inf, angle_increment=0.1, time_increment=0.0,
)  # fmt: skip


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        (CLOUD, with_fields(("x", 0), ("y", 4), ("z", 10))),
        (CLOUD, with_fields(("x", 0), ("y", 4), ("z", 8), ("x", 0))),
        (CLOUD, SimpleNamespace(height=1, width=1)),
        (LASER, LASER_SCAN),
    ],
    ids=["field beyond the step", "field twice", "no header", "infinite angle"],
)
def test_a_message_that_is_no_sweep_is_one_line_without_warnings(kind, message):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(InputError, match=r"^drive\.bag: "):
            list(of_message(kind, message).sweeps())


def test_a_pose_without_a_header_is_one_line():
    with pytest.raises(InputError, match=r"^drive\.bag: not readable as nav_msgs/Odometry on /p"):
        of_message(ODOMETRY, SimpleNamespace(pose=None)).poses("/p")


def test_an_empty_cloud_of_height_0_is_a_sweep_without_points():
    message = cloud([], ["x", "y", "z"], ["<f4"] * 3)
    message.height = 0
    assert [len(sweep) for sweep in of_message(CLOUD, message).sweeps()] == [0]


def test_a_field_of_several_values_is_refused():
    table = np.zeros(4, [("x", "<f4", (3,)), ("y", "<f4"), ("z", "<f4")])
    with pytest.raises(InputError, match="points have 3 values of field x; write one"):
        sweep_of_table(table, 0.0, 0)


def test_rings_that_are_no_numbers_give_no_warning():
    message = cloud([(1, 2, 3, np.nan)], ["x", "y", "z", "ring"], ["<f4"] * 4)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(sweep_of(CLOUD, message, 0.0, 0)) == 1
