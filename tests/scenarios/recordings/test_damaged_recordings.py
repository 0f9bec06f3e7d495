"""Damaged, empty and wrong files: one line on standard error, exit code 2, and no folder."""

import json
import struct
import sys

import numpy as np
import pytest
from support import recorded_drive as drive
from support.optional import need

from luxloop.scenarios.cli import main
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.recordings.formats.ouster_capture import require_columns

MOUNT = ("--mount", "0,0,1")


def bag(folder):
    return drive.write_ros1(folder / "drive.bag")


def ros2(folder):
    return next(drive.write_ros2(folder / "drive").glob("*.db3"))


def mcap(folder):
    return next(drive.write_ros2(folder / "drive", "MCAP").glob("*.mcap"))


def points(folder):
    path = folder / "a.bin"
    np.arange(40, dtype="<f4").tofile(path)
    return path


def pcd(folder):
    path = folder / "a.pcd"
    header = "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 5\nHEIGHT 1\nPOINTS 5\nDATA binary\n"
    path.write_bytes(header.encode() + np.ones(15, "<f4").tobytes())
    return path


def capture(folder):
    need("recordings")
    path = folder / "a.pcap"
    head = struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 1)
    path.write_bytes(head + 3 * (struct.pack("<IIII", 0, 0, 100, 100) + bytes(100)))
    (folder / "a.json").write_text("{}")
    return path


WRITERS = {"bag": bag, "ros2": ros2, "mcap": mcap, "bin": points, "pcd": pcd, "pcap": capture}


def refused(capsys, out, *arguments):
    """Return the one line of an import that fails, and check that nothing was written."""
    capsys.readouterr()
    code = main(["import", *map(str, arguments), "--out", str(out)])
    lines = capsys.readouterr().err.splitlines()
    assert (code, len(lines)) == (2, 1), lines
    assert not out.exists()
    assert not [path for path in out.parent.iterdir() if "partial" in path.name]
    return lines[0]


@pytest.mark.parametrize("kind", WRITERS)
def test_a_truncated_file_is_refused(kind, tmp_path, capsys):
    path = WRITERS[kind](tmp_path)
    path.write_bytes(path.read_bytes()[: int(0.6 * path.stat().st_size) - 3])
    assert str(path) in refused(capsys, tmp_path / "out", path, *MOUNT)


def test_a_truncated_mcap_names_its_repair(tmp_path, capsys):
    path = mcap(tmp_path)
    path.write_bytes(path.read_bytes()[: int(0.6 * path.stat().st_size)])
    assert "ends within the recording; recover it with `mcap recover`" in refused(
        capsys, tmp_path / "out", path, *MOUNT
    )


@pytest.mark.parametrize("kind", WRITERS)
def test_an_empty_file_is_refused(kind, tmp_path, capsys):
    path = WRITERS[kind](tmp_path)
    path.write_bytes(b"")
    assert "is empty" in refused(capsys, tmp_path / "out", path, *MOUNT)


@pytest.mark.parametrize("kind", [*WRITERS, "lux"])
def test_a_file_of_another_format_is_refused(kind, tmp_path, capsys):
    if kind in ("bag", "ros2", "mcap", "pcap"):
        need("recordings")
    suffix = {"bag": "bag", "ros2": "db3", "lux": "lux"}.get(kind, kind)
    path = tmp_path / f"a.{suffix}"
    path.write_text(
        "A text of a hundred letters is no recording of a sensor, even if the name of its file says so. 123456"
    )
    (tmp_path / "a.json").write_text("{}")
    assert str(path) in refused(capsys, tmp_path / "out", path, *MOUNT)


def test_missing_files_and_wrong_options_name_the_remedy(tmp_path, capsys):
    out, path = tmp_path / "out", bag(tmp_path)
    assert "no such file" in refused(capsys, out, tmp_path / "none.bag", *MOUNT)
    assert "--mount" in refused(capsys, out, path)
    assert "--mount 1,2" in refused(capsys, out, path, "--mount", "1,2")
    assert "the recording has /scan" in refused(capsys, out, path, *MOUNT, "--topic", "/laser")
    assert "/car, /ego" in refused(capsys, out, path, *MOUNT, "--odometry", "/odom")
    assert "--truth needs --odometry" in refused(capsys, out, path, *MOUNT, "--truth", "/car=4,2")
    assert "--truth /car=4" in refused(capsys, out, path, *MOUNT, "--odometry", "/ego", "--truth", "/car=4")
    assert "--layers and --heights" in refused(capsys, out, path, *MOUNT, "--layers", "1", "--heights", "1")
    assert "--layers 1,a" in refused(capsys, out, path, *MOUNT, "--layers", "1,a")
    assert "--keep-heights 2,1" in refused(capsys, out, path, *MOUNT, "--keep-heights", "2,1")
    assert "--scale-length -1" in refused(capsys, out, path, *MOUNT, "--scale-length=-1")
    assert "--format laz" in refused(capsys, out, path, *MOUNT, "--format", "laz")
    assert "no sweep can be used" in refused(capsys, out, path, *MOUNT, "--keep-heights", "5,6")


@pytest.mark.parametrize("key", ["columns_per_packet", "columns_per_frame", "pixels_per_column"])
def test_packets_without_columns_are_refused_before_the_library_divides_by_them(key, tmp_path):
    """ouster-sdk 1.0.1 ends the process by SIGFPE."""
    path = tmp_path / "a.json"
    path.write_text(json.dumps({"lidar_data_format": {key: 0}}))
    with pytest.raises(InputError, match=rf"a\.json: {key} = 0: should be 1 to 65536"):
        require_columns(path)


def test_another_folder_is_not_replaced(tmp_path, capsys):
    path = points(tmp_path)
    (tmp_path / "notes").mkdir()
    (tmp_path / "notes" / "a.txt").write_text("mine")
    assert main(["import", str(path), *MOUNT, "--out", str(tmp_path / "notes")]) == 2
    assert "holds other files" in capsys.readouterr().err
    assert (tmp_path / "notes" / "a.txt").read_text() == "mine"


def test_a_capture_without_its_library_names_the_command_that_installs_it(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "ouster", None)
    path, out = capture(tmp_path), tmp_path / "out"
    assert main(["import", str(path), "--mount", "0,0,1", "--out", str(out)]) == 2
    printed, error = capsys.readouterr()
    assert printed == ""
    assert error.endswith("which is not installed: pip install --no-deps ouster-sdk==1.0.1\n")
    assert len(error.splitlines()) == 1
