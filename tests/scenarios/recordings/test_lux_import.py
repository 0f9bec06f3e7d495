"""LUX scan messages as recorded scans: a simulated scan, written by the codec, and read back."""

import numpy as np
import pytest
from support.real_data import real_file

from luxloop.scenarios.cli import main
from luxloop.scenarios.recordings.recording import Recording
from luxloop.sensor_model.formats.lux_scan_points import scan_messages
from luxloop.sensor_model.formats.lux_scan_stream import stream_bytes
from luxloop.sensor_model.rig.rig import SHIPPED, load_rig
from luxloop.tracker.scan import Scan

RIG = load_rig("srx_six_lux", SHIPPED)


def ego_scan(time):
    """Points in front of the front units, on a layer each of their own elevation."""
    mount = RIG.mounts[0]
    azimuth = np.deg2rad(np.repeat([20.0, 0.0, -20.0], 4))
    layer = np.tile(np.arange(4), 3)
    elevation = np.deg2rad(np.array(mount.model.layer_elevation_deg))[layer]
    level = 12.0 * np.cos(elevation)
    unit = np.column_stack([level * np.cos(azimuth), level * np.sin(azimuth), 12.0 * np.sin(elevation)])
    yaw = np.deg2rad(mount.yaw_deg)
    turn = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    place = np.array([RIG.rear_axle_x_m + mount.x_m, mount.y_m, mount.z_m])
    return Scan.from_points(time, unit @ turn.T + place, layer=layer, echo_pulse_width=1.64, flags=1)


def test_a_stream_of_one_unit_gives_its_points_back(tmp_path):
    path = tmp_path / "unit.lux"
    path.write_bytes(b"".join(stream_bytes([scan_messages(ego_scan(0.08 * k), RIG, k)[0] for k in range(3)])))
    (tmp_path / "one.toml").write_text(
        'rear_axle_x_m = -1.385\nmodel = "lux"\n[[unit]]\nname = "front left"\nx_m = 3.55\ny_m = 0.75\nz_m = 0.55\n'
        "yaw_deg = 30.0\npitch_deg = 0.0\nroll_deg = 0.0\n"
    )
    code = main(["import", str(path), "--rig", str(tmp_path / "one.toml"), "--out", str(tmp_path / "out")])
    assert code == 0
    recording = Recording(tmp_path / "out")
    found = list(recording.scans())
    assert recording.time_s == pytest.approx([0.0, 0.08, 0.16], abs=1e-4)
    true = ego_scan(0.0)
    order = np.lexsort((true.layer, np.round(true.points_ego[:, 1], 2)))
    back = np.lexsort((found[0].layer, np.round(found[0].points_ego[:, 1], 2)))
    # Ticks of 1/32 degree at 12 m are 6.5 mm, ranges are whole cm.
    assert found[0].points_ego[back] == pytest.approx(true.points_ego[order], abs=0.01)
    assert found[0].echo_pulse_width == pytest.approx(1.64)
    assert (found[0].flags == 1).all()
    assert (tmp_path / "out" / "rig.json").is_file()
    # The unit fires left before right: from 20 to -20 degrees in 40 / 360 of 80 ms.
    assert np.ptp(found[0].time_offset) == pytest.approx(0.08 * 40 / 360, abs=2e-3)


def test_a_fragment_is_one_line(tmp_path, capsys):
    path = real_file("lux/scan_0x2202.bin")
    assert main(["import", str(path), "--format", "lux", "--mount", "0,0,1", "--out", str(tmp_path / "out")]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert "740 points" in lines[0]
    assert not (tmp_path / "out").exists()
