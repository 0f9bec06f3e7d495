"""PointCloud2 messages of common drivers, packed by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.recordings.formats.ros_topics import CLOUD, sweep_of

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
