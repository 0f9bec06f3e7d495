"""Simulated scans as LUX messages, and back."""

from dataclasses import replace

import numpy as np
import pytest
from support.sensor_scenes import LUX_RIG, ActorSpec, scan

from luxloop.sensor_model.formats.lux_scan_message import decode, encode
from luxloop.sensor_model.formats.lux_scan_points import points_unit, scan_messages
from luxloop.tracker.scan import Scan

ELEVATION_DEG = LUX_RIG.mounts[0].model.layer_elevation_deg
LEFT = LUX_RIG.mounts[2]


def test_a_point_of_a_turned_unit_is_written_in_the_frame_of_that_unit():
    """The unit looks 90 degrees to the left from (1, 2, 0.5); layer 2 rises by 0.4 degrees."""
    mount = replace(LEFT, x_m=1.0, y_m=2.0, z_m=0.5, yaw_deg=90.0, pitch_deg=0.0, roll_deg=0.0)
    rig = replace(LUX_RIG, rear_axle_x_m=0.0, mounts=(mount,))
    level, up = 20.0 * np.cos(np.deg2rad(0.4)), 20.0 * np.sin(np.deg2rad(0.4))
    turn = np.deg2rad(30.0)  # left of the optical axis
    point = (1.0 - level * np.sin(turn), 2.0 + level * np.cos(turn), 0.5 + up)
    one = Scan.from_points(1.5, [point], layer=2, echo=1, echo_pulse_width=0.84, flags=3)
    (message,) = scan_messages(one, rig, 65_537)
    assert (message.azimuth_ticks[0], message.range_cm[0], message.width_cm[0]) == (960, 2000, 84)
    assert (message.layer[0], message.echo[0], message.flags[0]) == (2, 1, 3)
    header = message.header
    assert (header.scan_number, header.points) == (1, 1)
    assert (header.mount_yaw_ticks, header.mount_x_cm, header.mount_y_cm, header.mount_z_cm) == (2880, 100, 200, 50)
    np.testing.assert_allclose(
        points_unit(message, ELEVATION_DEG), [[level * np.cos(turn), level * np.sin(turn), up]], atol=1e-9
    )


def test_a_scan_of_six_units_survives_its_messages():
    around = [ActorSpec(12.0 * np.cos(a), 12.0 * np.sin(a)) for a in np.arange(0.0, 6.0, 0.5)]
    sweep, _ = scan(*around, index=4)
    messages = [decode(encode(message)) for message in scan_messages(sweep, LUX_RIG, 4)]
    assert [len(message) for message in messages] == np.bincount(sweep.unit, minlength=6).tolist()
    for u, (mount, message) in enumerate(zip(LUX_RIG.mounts, messages, strict=True)):
        rows = np.flatnonzero(sweep.unit == u)
        time = np.round(sweep.time_offset[rows].astype(np.float64), 6)
        rows = rows[np.lexsort((sweep.echo[rows], sweep.layer[rows], time))]
        np.testing.assert_array_equal(message.layer, sweep.layer[rows])
        np.testing.assert_array_equal(message.echo, sweep.echo[rows])
        np.testing.assert_array_equal(message.flags, sweep.flags[rows])
        np.testing.assert_allclose(message.width_cm / 100, sweep.echo_pulse_width[rows], atol=1e-5)
        seconds = message.header.start_ntp - (2_208_988_800 << 32)
        fired = seconds / 2.0**32 + message.time_offset
        np.testing.assert_allclose(fired, sweep.time + sweep.time_offset[rows], atol=2e-6)
        yaw = np.deg2rad(mount.yaw_deg)
        assert (mount.pitch_deg, mount.roll_deg) == (0.0, 0.0)
        x, y, z = points_unit(message, mount.model.layer_elevation_deg).T
        back = np.stack(
            [
                LUX_RIG.rear_axle_x_m + mount.x_m + np.cos(yaw) * x - np.sin(yaw) * y,
                mount.y_m + np.sin(yaw) * x + np.cos(yaw) * y,
                mount.z_m + z,
            ],
            axis=1,
        )
        reach = np.linalg.norm(sweep.points_ego[rows], axis=1)
        error = np.linalg.norm(back - sweep.points_ego[rows], axis=1)
        assert len(rows) > 20
        # Half a centimetre of range, and half a tick: 1/64 degree.
        assert np.all(error <= 0.006 + (reach + 5.0) * np.deg2rad(1 / 64))


def test_an_instantaneous_scan_has_one_time():
    (first, *_) = scan_messages(Scan.from_points(3.0, np.empty((0, 3))), LUX_RIG, sweep=False)
    assert first.header.start_ntp == first.header.end_ntp == (2_208_988_803 << 32)
    assert len(first) == 0
    assert points_unit(first, ELEVATION_DEG).shape == (0, 3)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"unit": 6}, "unit = 6: the rig has units 0 to 5"),
        ({"echo_pulse_width": 700.0}, "echo_pulse_width from 700.0 to 700.0 m: a scan message has 0 to 655.35 m"),
        ({"points": [(900.0, 0.0, 0.5)]}, r"range from 89\d\.\d+ to 89\d\.\d+ m"),
        ({"time": -2.3e9}, "time = .* outside NTP time"),
    ],
)
def test_what_a_message_cannot_hold_is_refused(values, words):
    values = {"points": [(10.0, 0.0, 0.5)], "time": 0.0, **values}
    with pytest.raises(ValueError, match=words):
        scan_messages(Scan.from_points(values.pop("time"), values.pop("points"), **values), LUX_RIG)


def test_a_layer_without_elevation_is_refused():
    (message, *_) = scan_messages(Scan.from_points(0.0, [(10.0, 0.0, 0.5)], layer=3), LUX_RIG)
    with pytest.raises(ValueError, match=r"layer = 3: layer_elevation_deg has 2 numbers"):
        points_unit(message, (0.0, 1.0))
