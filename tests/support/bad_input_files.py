"""Valid files of runs and recordings, small and fast to read, which `support.bad_input` mutates."""

import io
import struct
import tempfile
from collections.abc import Callable
from contextlib import redirect_stdout
from functools import cache
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from support import short_run
from support.bad_traffic_files import SHORT, STUDY, Files, as_csv, scenario
from support.mutate_tables import parquet
from support.optional import need


def _made(*command: str) -> None:
    from luxloop.scenarios.cli import main

    with redirect_stdout(io.StringIO()):
        assert main(list(command)) in (0, 1), command


@cache
def run() -> Files:
    """A run with its scans, and a file of tracks for it."""

    def make(folder: Path) -> None:
        path = str(short_run.write(folder, SHORT))
        _made("run", path, "--no-recording", "--record-scans", "--quiet", "--out", str(folder / "run"))

    return _folder_of(make, "run") | {"tracks.csv": as_csv(tracks())}


@cache
def recording() -> Files:
    """A recording with labels, imported from a short bag."""
    from support import recorded_drive as bag

    def make(folder: Path) -> None:
        (folder / "a.bag").write_bytes(_bag())
        _made("import", str(folder / "a.bag"), "--out", str(folder / "rec"), *bag.OPTIONS)

    return _folder_of(make, "rec")


def _folder_of(make: Callable[[Path], None], name: str) -> Files:
    with tempfile.TemporaryDirectory() as folder:
        make(Path(folder))
        paths = [path for path in sorted(Path(folder, name).rglob("*")) if path.is_file()]
        return {str(path.relative_to(folder)): path.read_bytes() for path in paths}


@cache
def tracks() -> pa.Table:
    """One track for the two frames of the run."""
    return pa.table(
        {
            "frame": [0, 1], "track_id": [1, 1], "x_odom_m": [9.0, 9.4], "y_odom_m": [3.0, 3.0],
            "heading_odom_rad": [0.0, 0.0], "length_m": [4.5, 4.5], "width_m": [1.8, 1.8],
            "vx_odom_mps": [5.0, 5.0], "vy_odom_mps": [0.0, 0.0],
            "status": ["confirmed", "confirmed"],
        }
    )  # fmt: skip


@cache
def tracks_csv() -> Files:
    return run()


@cache
def tracks_parquet() -> Files:
    return run() | {"tracks.parquet": parquet(tracks())}


@cache
def boxes() -> Files:
    """Truth and tracks in files of every format that `luxloop grade --truth` reads."""
    from support import box_files
    from support.box_files import Box

    truth = [Box(k, f"{car}", 9.0 + k, 4.0 * car, 0.1, 4.5, 1.8) for k in range(3) for car in range(2)]
    tracks = [box._replace(x=box.x + 0.3, score=0.7) for box in truth]
    found = {
        "a.csv": box_files.csv(truth), "b.csv": box_files.csv(tracks), "a.txt": box_files.kitti(truth, scored=False),
        "b.txt": box_files.kitti(tracks), "a.json": box_files.nuscenes(truth), "b.json": box_files.nuscenes(tracks),
    }  # fmt: skip
    return {name: content.encode() for name, content in found.items()}


@cache
def nuscenes_folder() -> Files:
    """Tables and tracks of the run, as `luxloop export` writes them."""

    def make(folder: Path) -> None:
        _unpack(run(), folder)
        _made("export", str(folder / "run"), "--format", "nuscenes", "--out", str(folder / "scene"))

    return _folder_of(make, "scene")


@cache
def boxes_mcap() -> Files:
    """The run with truth and tracks as `luxloop mcap` writes it."""
    need("mcap")

    def make(folder: Path) -> None:
        _unpack(run(), folder)
        (folder / "made").mkdir()
        _made("mcap", str(folder / "run"), str(folder / "made" / "run.mcap"))

    (content,) = _folder_of(make, "made").values()
    return {"run.mcap": content}


@cache
def boxes_osi() -> Files:
    """The run with truth and tracks as `luxloop export --format osi` writes it."""
    need("osi")

    def make(folder: Path) -> None:
        _unpack(run(), folder)
        _made("export", str(folder / "run"), "--format", "osi", "--out", str(folder / "made"))

    (content,) = _folder_of(make, "made").values()
    return {"trace.mcap": content}


def _unpack(files: Files, folder: Path) -> None:
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)


def table_of(files: Callable[[], Files], name: str) -> Callable[[], pa.Table]:
    """Return a function that reads a Parquet file of `files` once."""
    return cache(lambda: pq.read_table(io.BytesIO(files()[name])))


@cache
def baseline() -> Files:
    """Two equal baseline files."""

    def make(folder: Path) -> None:
        _unpack(run(), folder)
        (folder / "made").mkdir()
        _made("baseline", str(folder / "run"), "--out", str(folder / "made" / "base.jsonl"))

    (content,) = _folder_of(make, "made").values()
    return {"base.jsonl": content, "head.jsonl": content}


@cache
def bin_scan() -> Files:
    rng = np.random.default_rng(1)
    rows = np.column_stack([rng.uniform(-20, 20, (100, 3)), rng.uniform(0, 1, 100)])
    return {"a.bin": rows.astype("<f4").tobytes()}


def _pcd(data: str, content: bytes) -> Files:
    header = (
        f"VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 50\nHEIGHT 1\nPOINTS 50\nDATA {data}\n"
    )
    return {"a.pcd": header.encode() + content}


def _points() -> np.ndarray:
    return np.random.default_rng(1).uniform(-20, 20, (50, 3)).astype("<f4")


@cache
def pcd_ascii() -> Files:
    return _pcd("ascii", "\n".join(" ".join(map(str, row)) for row in _points().tolist()).encode())


@cache
def pcd_binary() -> Files:
    return _pcd("binary", _points().tobytes())


@cache
def pcd_compressed() -> Files:
    """Literal runs of LZF only."""
    plain = _points().T.tobytes()
    packed = b"".join(bytes([len(part) - 1]) + part for part in (plain[k : k + 32] for k in range(0, len(plain), 32)))
    return _pcd("binary_compressed", struct.pack("<II", len(packed), len(plain)) + packed)


@cache
def lux() -> Files:
    """Three scans of one unit."""
    from luxloop.sensor_model.formats.lux_scan_points import scan_messages
    from luxloop.sensor_model.formats.lux_scan_stream import stream_bytes
    from luxloop.sensor_model.rig.rig import SHIPPED, load_rig
    from luxloop.tracker.scan import Scan

    model = load_rig("srx_six_lux", SHIPPED)
    points = np.column_stack([np.full(12, 12.0), np.linspace(-3, 3, 12), np.full(12, 0.6)])
    scans = [
        Scan.from_points(0.08 * k, points, layer=np.arange(12) % 4, echo_pulse_width=1.64, flags=1) for k in range(3)
    ]
    one = 'rear_axle_x_m = -1.385\nmodel = "lux"\n[[unit]]\nname = "front left"\nx_m = 3.55\ny_m = 0.75\nz_m = 0.55\n'
    return {
        "a.lux": b"".join(stream_bytes([scan_messages(scan, model, k)[0] for k, scan in enumerate(scans)])),
        "one.toml": (one + "yaw_deg = 30.0\npitch_deg = 0.0\nroll_deg = 0.0\n").encode(),
    }


@cache
def _bag() -> bytes:
    return _of_drive(lambda drive, folder: drive.write_ros1(folder / "a.bag"))


def _of_drive(make: Callable[..., Path]) -> bytes:
    """Return the file of a drive of six scans."""
    from unittest.mock import patch

    from support import recorded_drive

    with tempfile.TemporaryDirectory() as folder, patch.object(recorded_drive, "SCANS", 6):
        return make(recorded_drive, Path(folder)).read_bytes()


@cache
def bag() -> Files:
    return {"a.bag": _bag()}


@cache
def mcap() -> Files:
    return {"a.mcap": _of_drive(lambda drive, folder: next(drive.write_ros2(folder / "d", "MCAP").glob("*.mcap")))}


@cache
def sqlite() -> Files:
    return {"a.db3": _of_drive(lambda drive, folder: next(drive.write_ros2(folder / "d").glob("*.db3")))}


@cache
def all_files() -> Files:
    """Files for commands whose arguments are mutated."""
    return scenario() | run() | baseline() | bin_scan() | {"study.toml": STUDY.encode()}
