"""LUX streams: bytes at the offsets of the public drivers, and round trips bit for bit with our readers."""

import struct

import numpy as np
import pandas as pd
import pytest
from support import exported_run, short_run
from support.paths import ROOT

from luxloop.scenarios.cli import main
from luxloop.scenarios.grading.plane_geometry import into_frame
from luxloop.scenarios.offline.recorded_scans import RecordedRun
from luxloop.sensor_model.formats import lux_fused_scan, lux_object_list
from luxloop.sensor_model.formats.lux_scan_message import encode
from luxloop.sensor_model.formats.lux_scan_points import points_unit, scan_messages
from luxloop.sensor_model.formats.lux_scan_stream import read_framed, read_stream, stream_bytes
from luxloop.sensor_model.rig.beams import unit_table

NTP_1970_S = 2_208_988_800


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return exported_run.exported(tmp_path_factory.mktemp("lux"), "lux")


@pytest.fixture(scope="module")
def run(folder):
    return RecordedRun.open(folder / "run")


@pytest.fixture(scope="module")
def frames(run):
    return list(run.scans())


@pytest.fixture(scope="module")
def fusion(folder):
    """Bodies of the fusion system by type."""
    found = {}
    for data_type, body in read_framed(folder / "lux" / "fusion.lux"):
        found.setdefault(data_type, []).append(body)
    return found


def test_every_unit_has_a_stream_that_is_read_back_bit_for_bit(folder, run, frames):
    units, total = unit_table(run.rig), 0
    for unit, mount in enumerate(run.rig.mounts):
        path = folder / "lux" / f"{mount.name}.lux"
        messages = list(read_stream(path))
        assert b"".join(stream_bytes(messages, device=unit + 1)) == path.read_bytes()
        for (frame, scan, _), message in zip(frames, messages, strict=True):
            assert encode(message) == encode(scan_messages(scan, run.rig, frame.index)[unit])
            rows = np.flatnonzero(scan.unit == unit)
            ego = (
                points_unit(message, mount.model.layer_elevation_deg) @ units.R_ego_unit[unit].T
                + units.origin_ego[unit]
            )
            nearest = np.linalg.norm(ego[:, None] - scan.points_ego[rows][None], axis=2).min(axis=1, initial=np.inf)
            assert len(message) == len(rows)
            assert (nearest < 0.005 + 1e-3 * message.range_cm / 100).all()
            total += len(rows)
    assert total > 1000


def test_fused_scans_have_the_bytes_of_the_drivers(fusion, run, frames):
    """Offsets of `ScanData2205`, `ScannerInfo2205` and `ScanPoint2205` in ibeo_core.cpp."""
    for (frame, scan, _), body in zip(frames, fusion[0x2205], strict=True):
        start, duration, flags = struct.unpack_from(">QII", body, 0)
        number, points, units = struct.unpack_from(">HHB", body, 16)
        assert (flags, number, points, units) == (0x100 | 0x400, frame.index, len(scan), len(run.rig.mounts))
        assert len(body) == 24 + 148 * units + 28 * points
        started = start / 2.0**32 - NTP_1970_S
        for unit, mount in enumerate(run.rig.mounts):
            at = 24 + 148 * unit
            assert struct.unpack_from(">BBH", body, at) == (unit + 1, 6, frame.index)
            # the two mirror faces sweep from 50 to -50 and from 34.75 to -59.75 degrees
            np.testing.assert_allclose(struct.unpack_from(">2f", body, at + 8), np.deg2rad([50.0, -59.75]), rtol=1e-6)
            np.testing.assert_allclose(struct.unpack_from(">f", body, at + 48), mount.model.scan_rate_hz)
            pose = [*np.deg2rad([mount.yaw_deg, mount.pitch_deg, mount.roll_deg]), mount.x_m, mount.y_m, mount.z_m]
            np.testing.assert_allclose(struct.unpack_from(">6f", body, at + 60), pose, rtol=1e-6)
        for row in range(0, points, 7):
            at = 24 + 148 * units + 28 * row
            x, y, z, width = struct.unpack_from(">4f", body, at)
            np.testing.assert_allclose([x + run.rig.rear_axle_x_m, y, z], scan.points_ego[row], atol=1e-5)
            assert (y, z, width) == (*scan.points_ego[row, 1:], scan.echo_pulse_width[row])
            device, layer, echo = struct.unpack_from(">BBB", body, at + 16)
            assert (device - 1, layer, echo) == (scan.unit[row], scan.layer[row], scan.echo[row])
            (offset_us,) = struct.unpack_from(">I", body, at + 20)
            assert offset_us <= duration
            assert started + 1e-6 * offset_us == pytest.approx(frame.time + scan.time_offset[row], abs=2e-6)
            (set_flags,) = struct.unpack_from(">H", body, at + 24)
            own = int(scan.flags[row])
            assert set_flags == (own & 1) << 12 | (own & 2) << 1 | (own & 4) >> 2 | (own & 8) >> 2


def test_object_lists_have_the_bytes_of_the_drivers(fusion, run, frames):
    """Offsets of `ObjectData2280` and `Object2280` in ibeo_core.cpp: objects of 168 bytes from offset 10."""
    tracks, shown = run.result.tables["tracks"], 0
    for (frame, _, _), body in zip(frames, fusion[0x2280], strict=True):
        own = tracks[(tracks["frame"] == frame.index) & (tracks["status"] == "confirmed")]
        middle, count = struct.unpack_from(">QH", body, 0)
        assert middle == (NTP_1970_S << 32) + round(frame.time * 2**32)
        assert (count, len(body)) == (len(own), 10 + 168 * len(own))
        for number, track in enumerate(own.itertuples()):
            at = 10 + 168 * number
            assert struct.unpack_from(">H", body, at) == (track.track_id,)
            first = tracks.loc[tracks["track_id"] == track.track_id, "frame"].min()
            assert struct.unpack_from(">I", body, at + 4) == (frame.index - first,)
            pose = np.array([[track.x_world_m, track.y_world_m, track.yaw_world_rad]])
            x, y, course = into_frame(pose, frame.ego.pose_world)[0]
            expected = [x - run.rig.rear_axle_x_m, y, track.length_m, track.width_m, course]
            found = [
                *struct.unpack_from(">2f", body, at + 40), *struct.unpack_from(">2f", body, at + 56),
                *struct.unpack_from(">f", body, at + 72),
            ]  # fmt: skip
            np.testing.assert_array_equal(found, np.float32(expected))
            turn = frame.ego.pose_world[2]
            velocity = np.array([track.vx_world_mps, track.vy_world_mps])
            for offset, over in ((96, velocity), (80, velocity - frame.ego.velocity_world)):
                ahead = np.cos(turn) * over[0] + np.sin(turn) * over[1]
                left = np.cos(turn) * over[1] - np.sin(turn) * over[0]
                np.testing.assert_allclose(struct.unpack_from(">2f", body, at + offset), [ahead, left], atol=1e-6)
            assert struct.unpack_from(">2f", body, at + 134) == tuple(np.float32(expected[:2]))
            shown += 1
    assert shown > short_run.FRAMES / 2


def test_messages_of_the_fusion_system_survive_decoding_bit_for_bit(fusion):
    for body in fusion[0x2205]:
        assert lux_fused_scan.encode(lux_fused_scan.decode(body)) == body
    for body in fusion[0x2280]:
        assert lux_object_list.encode(lux_object_list.decode(body)) == body


@pytest.mark.parametrize("seed", [1, 2])
def test_any_bytes_survive_decoding_bit_for_bit(seed):
    """Reserved words, NaN and contours too."""
    rng = np.random.default_rng(seed)
    header = struct.pack(">QIIHHBHB", 5 << 32, 7, 0x700, 9, 3, 2, 0xABCD, 0xEF)
    body = header + rng.bytes(2 * 148 + 3 * 28)
    assert lux_fused_scan.encode(lux_fused_scan.decode(body)) == body
    objects = [bytearray(rng.bytes(168)) for _ in range(3)]
    for row, points in zip(objects, (2, 0, 255), strict=True):
        row[130] = points
    body = struct.pack(">QH", 5 << 32, 3) + objects[0] + rng.bytes(16) + objects[1] + objects[2]
    found = lux_object_list.decode(body)
    assert [len(contour) for contour in found.contours] == [2, 0, 0]
    assert lux_object_list.encode(found) == body


@pytest.mark.parametrize(
    ("decode", "data", "message"),
    [
        (lux_fused_scan.decode, bytes(23), "starts with 24 bytes of header, found 23"),
        (lux_fused_scan.decode, bytes(25), "0 units and 0 points declared, expected 24 bytes, found 25"),
        (lux_object_list.decode, bytes(9), "starts with 10 bytes of header, found 9"),
        (lux_object_list.decode, bytes(11), "offset 10: the message ends here by its number of objects, found 1 more"),
        (lux_object_list.decode, bytes(9) + b"\1" + bytes(5), "offset 10: object 0 of 1 has 168 bytes, found 5"),
    ],
)
def test_damaged_messages_are_refused(decode, data, message):
    with pytest.raises(ValueError, match=message):
        decode(data)


def test_a_stream_that_is_cut_off_names_file_and_offset(folder, tmp_path):
    data = (folder / "lux" / "fusion.lux").read_bytes()
    path = tmp_path / "cut.lux"
    path.write_bytes(data[:-1])
    with pytest.raises(ValueError, match=r"cut\.lux: offset \d+: expected \d+ bytes after the data header"):
        list(read_framed(path))
    path.write_bytes(data + b"abc")
    with pytest.raises(ValueError, match=rf"cut\.lux: offset {len(data)}: expected a data header of 24 bytes"):
        list(read_framed(path))


def test_streams_are_imported_as_recordings(folder, tmp_path, run, frames):
    """`luxloop import` reads the units like those of real LUX."""
    paths = [str(folder / "lux" / f"{mount.name}.lux") for mount in run.rig.mounts]
    rig = str(ROOT / "sensor_model" / "rigs" / "srx_six_lux.toml")
    out = tmp_path / "recorded"
    assert main(["import", *paths, "--format", "lux", "--rig", rig, "--out", str(out)]) == 0
    points = pd.read_parquet(out / "points.parquet")
    assert len(points) == sum(len(scan) for _, scan, _ in frames)
    assert points["unit"].nunique() == len({unit for _, scan, _ in frames for unit in scan.unit.tolist()})


def test_the_export_is_reproducible(folder, tmp_path):
    assert main(["export", str(folder / "run"), "--format", "lux", "--out", str(tmp_path / "again")]) == 0
    for path in (folder / "lux").iterdir():
        assert (tmp_path / "again" / path.name).read_bytes() == path.read_bytes()
