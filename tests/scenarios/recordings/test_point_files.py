"""PCD and KITTI files: points, rings and times as written by hand."""

import struct

import numpy as np
import pytest

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.recordings.formats.format_choice import ReadOptions, format_of, open_recording
from luxloop.scenarios.recordings.formats.pcd_points import decompress

POINTS = np.array([(1.0, 2.0, 3.0, 5, 0), (4.0, 5.0, 6.0, 7, 1_000_000), (np.nan, 0.0, 0.0, 7, 2_000_000)],
                  dtype=[("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("ring", "<u2"), ("t", "<u4")])  # fmt: skip
HEADER = (
    "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z ring t\nSIZE 4 4 4 2 4\nTYPE F F F U U\n"
    "COUNT 1 1 1 1 1\nWIDTH 3\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA {}\n"
)


def literal(data):
    """Compress by literals only: the simplest valid LZF."""
    parts = [data[i : i + 32] for i in range(0, len(data), 32)]
    return b"".join(bytes([len(part) - 1]) + part for part in parts)


def body(data):
    if data == "ascii":
        return b"1 2 3 5 0\n4 5 6 7 1000000\nnan 0 0 7 2000000\n"
    if data == "binary":
        return POINTS.tobytes()
    columns = b"".join(POINTS[name].tobytes() for name in POINTS.dtype.names)
    packed = literal(columns)
    return struct.pack("<II", len(packed), len(columns)) + packed


def sweeps(paths, **options):
    return list(open_recording(paths, format_of(paths, None), ReadOptions(**options)).sweeps())


@pytest.mark.parametrize("data", ["ascii", "binary", "binary_compressed"])
def test_pcd_of_each_kind(data, tmp_path):
    path = tmp_path / "a.pcd"
    path.write_bytes(HEADER.format(data).encode() + body(data))
    (sweep,) = sweeps([path])
    assert sweep.points.tolist() == [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]
    assert sweep.ring.tolist() == [5, 7]
    assert sweep.time_offset == pytest.approx([0.0, 0.001])


@pytest.mark.parametrize("data", ["ascii", "binary", "binary_compressed"])
def test_truncated_pcd_names_the_file(data, tmp_path):
    path = tmp_path / "a.pcd"
    path.write_bytes((HEADER.format(data).encode() + body(data))[:-18])
    with pytest.raises(InputError, match=r"a\.pcd"):
        sweeps([path])


def test_kitti_files_are_sweeps_of_a_constant_rate(tmp_path):
    paths = [tmp_path / f"{number}.bin" for number in range(3)]
    for number, path in enumerate(paths):
        np.array([[1, 2, 3, 0.5], [number, 0, 1, 0.1]], dtype="<f4").tofile(path)
    found = sweeps(paths, rate_hz=20.0)
    assert [sweep.time for sweep in found] == pytest.approx([0.0, 0.05, 0.1])
    assert found[2].points.tolist() == [[1.0, 2.0, 3.0], [2.0, 0.0, 1.0]]
    assert found[0].ring is None


def test_lzf_copies_may_overlap_their_own_output():
    # Two literals "ab", then 7 bytes from 2 back: abababa; then the long form: 9 + 3 bytes from 1 back.
    packed = bytes([1]) + b"ab" + bytes([(5 << 5), 1]) + bytes([(7 << 5), 3, 0])
    assert decompress(packed, 21) == b"ababababa" + b"a" * 12


@pytest.mark.parametrize("packed", [bytes([(1 << 5), 9]), bytes([(7 << 5)]), b"\x01ab"])
def test_damaged_lzf_is_an_error(packed):
    with pytest.raises(ValueError, match="LZF"):
        decompress(packed, 5)
