"""PCD and KITTI files: points, rings and times as written by hand."""

import struct

import numpy as np
import pytest

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.exchange.kitti import kitti_drive
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


def test_times_of_pcd_in_a_given_unit(tmp_path):
    (tmp_path / "a.pcd").write_bytes(HEADER.format("ascii").encode() + b"1 2 3 5 0\n4 5 6 7 1000\n1 1 1 7 2000\n")
    (sweep,) = sweeps([tmp_path / "a.pcd"], time_unit_s=1e-6)
    assert sweep.time_offset == pytest.approx([0.0, 0.001, 0.002])


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


def test_files_of_nuscenes_have_rings(tmp_path):
    """Five floats a point: x, y, z, intensity, ring (nuScenes devkit, `LidarPointCloud.from_file`)."""
    rows = [[1.5, -2.0, 0.25, 12.0, 3.0], [-4.0, 5.0, -1.5, 0.0, 31.0], [7.5, 0.5, 0.125, 255.0, 0.0], [1, -1, 2, 8, 4]]
    np.array(rows, dtype="<f4").tofile(tmp_path / "a.bin")
    (sweep,) = sweeps([tmp_path / "a.bin"])
    assert sweep.points.tolist() == [row[:3] for row in rows]
    assert sweep.ring.tolist() == [3, 31, 0, 4]


def test_files_of_another_number_of_floats_are_refused(tmp_path):
    """Six floats: never points of garbage. Sixty values are points of four and of five floats by their number."""
    rng = np.random.default_rng(0)
    rows = np.column_stack([rng.normal(0.0, 20.0, (10, 3)), rng.uniform(0.0, 1.0, (10, 1)), rng.uniform(0, 9, (10, 2))])
    rows.astype("<f4").tofile(tmp_path / "a.bin")
    with pytest.raises(InputError, match=r"a\.bin: no points of float32 x, y, z, intensity, with or without ring"):
        sweeps([tmp_path / "a.bin"])
    np.zeros((5, 4), "<f4").tofile(tmp_path / "b.bin")
    with pytest.raises(InputError, match=r"b\.bin: points of both"):
        sweeps([tmp_path / "b.bin"])


@pytest.mark.parametrize("comment", ["# DATA of the drive", "# Aufnahme der Straße"])
def test_comments_in_a_pcd_header_are_skipped(comment, tmp_path):
    path = tmp_path / "a.pcd"
    path.write_bytes(f"{comment}\n{HEADER.format('binary')}".encode() + body("binary"))
    (sweep,) = sweeps([path])
    assert len(sweep) == 2


def test_lzf_copies_may_overlap_their_own_output():
    # Two literals "ab", then 7 bytes from 2 back: abababa; then the long form: 9 + 3 bytes from 1 back.
    packed = bytes([1]) + b"ab" + bytes([(5 << 5), 1]) + bytes([(7 << 5), 3, 0])
    assert decompress(packed, 21) == b"ababababa" + b"a" * 12


@pytest.mark.parametrize("packed", [bytes([(1 << 5), 9]), bytes([(7 << 5)]), b"\x01ab"])
def test_damaged_lzf_is_an_error(packed):
    with pytest.raises(ValueError, match="LZF"):
        decompress(packed, 5)


def test_files_without_numbers_are_one_error_without_a_warning(tmp_path, recwarn):
    pcd, times = tmp_path / "a.pcd", tmp_path / "0000.txt"
    pcd.write_bytes(HEADER.format("ascii").encode() + b"# no points\n")
    times.write_text("\n")
    with pytest.raises(InputError, match=r"a\.pcd: has 0 of 3 points"):
        sweeps([pcd])
    with pytest.raises(InputError, match=r"0000\.txt: not readable as numbers of KITTI"):
        kitti_drive.numbers(times, 1)
    assert list(recwarn) == []
