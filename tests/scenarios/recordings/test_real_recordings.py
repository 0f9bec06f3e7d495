"""Real recordings, where their folder is given: datmo's drives and Ouster's streets, see docs/recordings.md."""

import json

import numpy as np
import pytest
from support import separate_packages
from support.real_data import real_file

from luxloop.scenarios.cli import main
from luxloop.scenarios.recordings.recording import Recording

DATMO = (
    "--mount=-0.17,0,0.1", "--odometry", "/ego_pose", "--truth", "/red_pose=0.46,0.20,0.05,0,0.15",
    "--scale-length", "10", "--scale-time", "3.16228",
)  # fmt: skip
"""The laser is 0.17 m behind the markers; the red car is 0.46 x 0.20 m, its centre 0.05 m ahead of its markers."""
OUSTER = ("--mount", "0,0,1.8", "--level", "--heights", "0.45,0.6,0.8,0.95")


@pytest.mark.parametrize(
    ("name", "speed_mps"), [("parallel", 0.6), pytest.param("overtake_red", 0.8, marks=pytest.mark.slow)]
)
def test_the_red_car_is_tracked(name, speed_mps, tmp_path, capsys):
    bag, recorded, out = real_file(f"datmo/{name}.bag"), tmp_path / "recorded", tmp_path / "tracks"
    assert main(["import", str(bag), "--out", str(recorded), *DATMO]) == 0
    capsys.readouterr()
    assert main(["track", str(recorded), "--out", str(out), "--json"]) == 0
    metrics = json.loads(capsys.readouterr().out)["metrics"]
    assert metrics["track.id_switches"]["value"] == 0
    assert metrics["track.speed_abs_mean_mps"]["value"] < speed_mps
    assert metrics["track.heading_flip_rate"]["value"] == 0.0
    assert {"report.html", "recording.rrd"} <= {path.name for path in out.iterdir()}


def test_scans_agree_with_the_recording_read_by_others(tmp_path):
    bag, arrays = real_file("datmo/parallel.bag"), np.load(real_file("datmo/parallel.npz"))
    assert main(["import", str(bag), "--out", str(tmp_path / "out"), "--topic", "/scan", "--mount", "0,0,0.1"]) == 0
    recording = Recording(tmp_path / "out")
    assert len(recording) == len(arrays["scan_t"])
    for scan, ranges in zip(recording.scans(), arrays["ranges"], strict=True):
        valid = ranges[np.isfinite(ranges) & (ranges <= 8.0) & (ranges >= 0.15)]
        assert np.hypot(*scan.points_ego[:, :2].T) == pytest.approx(valid, abs=1e-5)


def test_an_ouster_capture_is_levelled_cut_and_tracked(tmp_path):
    capture = real_file("ouster/OS-1-128_v2.3.0_1024x10_lb_n3.pcap")
    separate_packages.append_to_path("ouster")
    assert main(["import", str(capture), "--out", str(tmp_path / "recorded"), *OUSTER]) == 0
    recording = Recording(tmp_path / "recorded")
    assert recording.time_s == pytest.approx([0.0, 0.1, 0.2], abs=0.001)
    assert 1.5 < recording.summary["mounts"][0]["origin_ego_m"][2] < 2.2  # on the roof of a car
    for scan in recording.scans():
        assert np.ptp(scan.time_offset) == pytest.approx(0.1, abs=0.002)
        assert set(np.unique(scan.layer)) == {0, 1, 2, 3}
        low = np.array([0.45, 0.6, 0.8, 0.95])[scan.layer]
        assert np.abs(scan.points_ego[:, 2] - low).max() <= 0.0801
    assert main(["track", str(recording.folder), "--out", str(tmp_path / "tracks")]) == 0
    assert {"report.html", "recording.rrd"} <= {path.name for path in (tmp_path / "tracks").iterdir()}


def test_a_truncated_capture_is_one_line(tmp_path, capsys):
    name = "ouster/OS-1-32-G_v2.1.1_1024x10"
    data = real_file(f"{name}.pcap").read_bytes()
    separate_packages.append_to_path("ouster")
    (tmp_path / "a.json").write_bytes(real_file(f"{name}.json").read_bytes())
    (tmp_path / "a.pcap").write_bytes(data[:-1000])
    assert main(["import", str(tmp_path / "a.pcap"), "--out", str(tmp_path / "out"), *OUSTER]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert "ends within a packet" in lines[0]
