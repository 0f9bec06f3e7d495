"""Beam table against the published figures of the units, repeated here independently."""

from dataclasses import replace
from math import pi, sin, sqrt
from pathlib import Path

import numpy as np
import pytest

from luxloop.sensor_model.rig.beams import beam_table, sweep_limits
from luxloop.sensor_model.rig.rig import SHIPPED, Mount, Rig, load_rig, load_unit

LUX_RIG = load_rig("srx_six_lux", Path())
LUX = beam_table(LUX_RIG)
UNITS = sorted(path.stem for path in (SHIPPED / "units").glob("*.toml"))
SHOTS_MAX, FINEST_MAX_DEG = 440, 20.0
"""Limits of a LUX: shots of a pair of layers in a scan, and degrees at the step of 0.125 (sick_ldmrs_laser)."""


def unit(name):
    return load_unit(name, Path())


def single(model, **pose):
    """Return the beam table of one unit, by default level and 1 m above the origin."""
    pose = dict.fromkeys(("x_m", "y_m", "yaw_deg", "pitch_deg", "roll_deg"), 0.0) | {"z_m": 1.0} | pose
    return beam_table(Rig(0.0, (Mount("only", model, **pose),)))


def from_ticks(first, last, step):
    """Return azimuths [deg]; a LUX has 11520 steps of 1/32 degree per turn (LD-MRS protocol 8014493)."""
    return [tick / 32 for tick in range(first, last - 1, -step)]


# Lower pair of layers from +50 to -50, upper pair from +34.75 to -59.75, every 0.5 deg; 0.8 deg from layer to layer.
LUX_LAYERS = {
    0: (-1.2, from_ticks(1600, -1600, 16)),
    1: (-0.4, from_ticks(1600, -1600, 16)),
    2: (0.4, from_ticks(1112, -1912, 16)),
    3: (1.2, from_ticks(1112, -1912, 16)),
}
LUX_YAWS_DEG = [30, -30, 95, -95, 150, -150]


def test_a_lux_has_782_beams_and_the_rig_4692():
    assert len(LUX) == 4692
    assert len(LUX.units) == 6
    assert np.bincount(LUX.unit).tolist() == [782] * 6
    assert sum(len(azimuths) for _, azimuths in LUX_LAYERS.values()) == 782
    for table in (LUX.azimuth, LUX.elevation, LUX.time_offset, LUX.gain, LUX.layer_bias, LUX.direction_ego):
        assert len(table) == 4692


@pytest.mark.parametrize("index", range(6))
@pytest.mark.parametrize("layer", range(4))
def test_beams_of_the_rig_have_the_directions_of_the_unit(index, layer):
    elevation_deg, azimuth_deg = LUX_LAYERS[layer]
    row = (LUX.unit == index) & (LUX.layer == layer)
    np.testing.assert_allclose(np.rad2deg(LUX.azimuth[row]), azimuth_deg, atol=1e-12)
    np.testing.assert_allclose(np.rad2deg(LUX.elevation[row]), elevation_deg, atol=1e-12)
    # Level mounts: the ego azimuth is the mount's yaw plus the beam's azimuth.
    x, y, z = LUX.direction_ego[row].T
    turned = np.rad2deg(np.arctan2(y, x)) - LUX_YAWS_DEG[index] - azimuth_deg
    np.testing.assert_allclose((turned + 180) % 360 - 180, 0.0, atol=1e-9)
    np.testing.assert_allclose(np.rad2deg(np.arcsin(z)), elevation_deg, atol=1e-9)


# Sensitivity over azimuth in percent of the centre, lower and upper pair (TU Darmstadt's LUX 2010, "from manual"; at
# the left ends of the pairs by the recorded scan, see test_lux_recording.py).
GAIN = {
    50: (4, 0), 49: (10, 0), 48: (22, 0), 47: (36, 0), 46: (48, 0), 43: (61, 0), 40: (64, 0), 36: (66, 0), 35: (66, 2),
    34: (67, 9), 33: (68, 24), 32: (70, 42), 31: (72, 58), 30: (74, 69),
    25: (84, 86), 20: (90, 94), 10: (97, 100), 0: (100, 100), -30: (100, 100), -40: (95, 97), -46: (85, 87),
    -48: (77, 84), -50: (35, 80), -54: (0, 70), -56: (0, 64), -58: (0, 60), -60: (0, 43),
}  # fmt: skip


@pytest.mark.parametrize("pair", [0, 1])
@pytest.mark.parametrize("azimuth_deg", GAIN)
def test_gain_at_its_knots(azimuth_deg, pair):
    # A fan of the same layers and gain with its one beam on the knot; the lower pair fires a quarter degree beside it.
    model = unit("lux")
    on_knot = replace(model.fans[pair], start_deg=float(azimuth_deg), stop_deg=float(azimuth_deg))
    gain = single(replace(model, fans=(on_knot,))).gain
    np.testing.assert_allclose(gain, GAIN[azimuth_deg][pair] / 100, rtol=0, atol=1e-12)


def test_gain_is_linear_between_the_knots():
    for pair, layers in enumerate([(0, 1), (2, 3)]):
        beam = np.isin(LUX.layer, layers)
        for azimuth_deg, gain in zip(np.rad2deg(LUX.azimuth[beam]), LUX.gain[beam], strict=True):
            left = min((knot for knot in GAIN if knot >= azimuth_deg - 1e-9), default=50)
            right = max(knot for knot in GAIN if knot <= azimuth_deg + 1e-9)
            share = (left - azimuth_deg) / (left - right) if left > right else 0.0
            expected = GAIN[left][pair] + max(share, 0.0) * (GAIN[right][pair] - GAIN[left][pair])
            assert gain == pytest.approx(expected / 100, abs=1e-9), (layers, azimuth_deg)


def test_receiver_of_the_lux_is_as_published():
    units = LUX.units
    # A surface of 10 % at 50 m is the weakest detected: 0.1 / 50^2 = 4e-5 / m^2.
    np.testing.assert_allclose(units.threshold, 4e-5)
    np.testing.assert_allclose(np.rad2deg([units.beam_width, units.beam_height]), [[0.08] * 6, [0.784] * 6])
    assert (units.range_min[0], units.range_max[0], units.echoes_max[0]) == (0.3, 200.0, 3)
    assert (units.range_quantum[0], units.pulse_quantum[0]) == (0.01, 0.04)
    # 1.2 to 1.8 cm in the recorded scan; TU Darmstadt has 2.5 cm for all echoes.
    assert 0.012 <= units.range_sigma[0] <= 0.018
    assert units.range_sigma_far[0] == 0.025
    # 4.5 ns of light, there and back.
    assert units.pulse_length[0] == pytest.approx(299792458 * 4.5e-9 / 2, abs=1e-3)
    assert units.echo_separation[0] == 5.0


def test_pulse_growth_is_as_hadelli_measured():
    # 0.45, 0.61 and 0.65 m on a 50 % target at 20, 15 and 10 m; least-squares line through the origin, over dB.
    over_threshold_db = 10 * np.log10(0.5 / np.array([20.0, 15.0, 10.0]) ** 2 / 4e-5)
    np.testing.assert_allclose(over_threshold_db, [14.9, 17.4, 21.0], atol=0.06)
    slope = np.linalg.lstsq(over_threshold_db[:, None], np.array([0.45, 0.61, 0.65]))[0][0]
    assert LUX.units.pulse_growth[0] == round(slope, 3)


def test_layer_biases_follow_the_layers():
    """Within a pair they are those of the recorded scan, between the pairs Blensor's 1.6, 3.0, 4.5 and 2.3 cm."""
    lower, upper = (1.6 + 3.0) / 2, (4.5 + 2.3) / 2
    common = (lower + upper) / 2
    expected_cm = np.array([lower - 1.9 / 2, lower + 1.9 / 2, upper + 0.7 / 2, upper - 0.7 / 2]) - common
    np.testing.assert_allclose(LUX.layer_bias, expected_cm[LUX.layer] / 100)
    for bias in (LUX.layer_bias, LUX.layer_pulse_bias):
        assert sum(bias[LUX.layer == layer][0] for layer in range(4)) == pytest.approx(0.0, abs=1e-12)


# --- when beams fire


@pytest.mark.parametrize(("name", "milliseconds"), [("lux", 24.4), ("lux_25hz", 12.2), ("lux_50hz", 6.1)])
def test_sweep_time_is_proportional_to_azimuth(name, milliseconds):
    table = single(unit(name))
    per_degree = np.ptp(table.time_offset) / np.rad2deg(np.ptp(table.azimuth))
    assert 1000 * per_degree * 110 == pytest.approx(milliseconds, abs=0.05)
    # Beams left of the axis fire before the frame's time, the axis at it.
    assert np.all(np.sign(table.time_offset) == -np.sign(table.azimuth))
    assert table.time_offset[np.isclose(table.azimuth, 0.0)] == pytest.approx(0.0, abs=1e-15)


def test_a_lux_at_25_hz_fires_the_same_beams_as_at_12():
    slow, fast = single(unit("lux")), single(unit("lux_25hz"))
    np.testing.assert_array_equal(fast.direction_ego, slow.direction_ego)
    np.testing.assert_allclose(fast.time_offset, slow.time_offset / 2)


def test_phase_shifts_only_the_beams_of_its_unit():
    mounts = list(LUX_RIG.mounts)
    mounts[2] = replace(mounts[2], phase_ms=7.5)
    later = beam_table(replace(LUX_RIG, mounts=tuple(mounts)))
    np.testing.assert_allclose(later.time_offset - LUX.time_offset, np.where(LUX.unit == 2, 0.0075, 0.0), atol=1e-15)
    np.testing.assert_array_equal(later.direction_ego, LUX.direction_ego)


def test_sweep_limits_are_the_first_and_last_beams_of_each_layer():
    """50 to -50 degrees and 34.75 to -59.75 at 4500 degrees per second, later by the phase of the unit."""
    mounts = (LUX_RIG.mounts[0], replace(LUX_RIG.mounts[1], phase_ms=7.5))
    limits = sweep_limits(beam_table(replace(LUX_RIG, mounts=mounts)))
    lux = np.array([[-50.0, 50.0], [-50.0, 50.0], [-34.75, 59.75], [-34.75, 59.75]]) / 4500.0
    assert limits.dtype == np.float32
    np.testing.assert_allclose(limits, [lux, lux + 0.0075], atol=1e-7)


def test_sweep_limits_of_layers_that_a_unit_lacks_are_nan():
    mixed = Rig(0.0, (replace(LUX_RIG.mounts[0]), replace(LUX_RIG.mounts[1], model=unit("lux_8l"))))
    limits = sweep_limits(beam_table(mixed))
    assert limits.shape == (2, 8, 2)
    assert np.isnan(limits[0, 4:]).all()
    assert np.isfinite(limits[0, :4]).all()
    assert np.isfinite(limits[1]).all()


# --- layout of the table, on which the caster relies


@pytest.mark.parametrize("name", UNITS)
def test_rows_have_even_steps_and_fans_rows_of_the_same_azimuths(name):
    table = beam_table(replace(LUX_RIG, mounts=tuple(replace(mount, model=unit(name)) for mount in LUX_RIG.mounts[:2])))
    assert (table.row_beam[0], table.row_beam[-1]) == (0, len(table))
    assert (table.fan_row[0], table.fan_row[-1]) == (0, len(table.row_beam) - 1)
    for fan, (first, step) in enumerate(table.fan_azimuth):
        assert step < 0.0
        for row in range(table.fan_row[fan], table.fan_row[fan + 1]):
            beams = slice(table.row_beam[row], table.row_beam[row + 1])
            count = table.row_beam[row + 1] - table.row_beam[row]
            np.testing.assert_allclose(table.azimuth[beams], first + step * np.arange(count), rtol=0, atol=1e-14)
            assert set(table.unit[beams]) == {table.fan_unit[fan]}
            assert len(set(table.layer[beams])) == 1
            assert np.all(np.diff(table.time_offset[beams]) > 0.0)
    half = len(table) // 2
    assert table.index.tolist() == 2 * list(range(half))
    assert table.unit.tolist() == [0] * half + [1] * half
    beams = np.column_stack([table.unit, table.layer, np.round(np.rad2deg(table.azimuth), 6)])
    assert len(np.unique(beams, axis=0)) == len(table)


def fires(table, frame):
    """Return the (B,) mask of beams that fire in a frame."""
    fan = np.repeat(np.arange(len(table.fan_unit)), np.diff(table.row_beam[table.fan_row]))
    return (frame % table.fan_turn[:, 1] == table.fan_turn[:, 0])[fan]


# --- other modes of the LUX


def shots(table):
    """Return the (S, 2) shots from left to right: pair of layers, which fires at once, and azimuth in degrees."""
    fired = np.column_stack([table.layer // 2, np.round(np.rad2deg(table.azimuth), 9)])
    fired, layers = np.unique(fired, axis=0, return_counts=True)
    assert np.all(layers == 2)
    return fired[np.argsort(-fired[:, 1], kind="stable")]


@pytest.mark.parametrize("name", ["lux", "lux_50hz", "lux_flexres", "lux_focused"])
def test_lux_fires_within_its_limits(name):
    model = unit(name)
    assert len(shots(single(model))) <= SHOTS_MAX
    for pair in [(0, 1), (2, 3)]:
        # 0.125 deg from pair to pair is 0.25 deg in each layer.
        finest_deg = sum(fan.count * fan.step_deg for fan in model.fans if fan.layers == pair and fan.step_deg == 0.25)
        assert finest_deg <= FINEST_MAX_DEG


# Default sectors of sick_ldmrs_laser: start, and step from pair to pair.
FLEXRES = [(50, 1), (35, 0.5), (30, 0.25), (20, 0.125), (0, 0.25), (-20, 0.5), (-30, 1), (-40, 0.5)]
FOCUSED = [(50, 0.5), (30, 0.25), (10, 0.125), (-10, 0.25), (-30, 0.5)]


@pytest.mark.parametrize(
    ("name", "sectors", "shots_of_110_deg"), [("lux_flexres", FLEXRES, 375), ("lux_focused", FOCUSED, 420)]
)
def test_each_sector_has_its_step_and_the_pairs_alternate(name, sectors, shots_of_110_deg):
    fired = shots(single(unit(name)))
    expected, counted = [], 0.0
    for (start, step), (stop, _) in zip(sectors, [*sectors[1:], (-60 - 1e-6, None)], strict=True):
        counted += (start - stop) / step  # as counted by the driver, for all pairs
        for shot in range(int(np.ceil((start - stop) / step - 1e-9))):
            azimuth, upper = start - shot * step, shot % 2 == 0
            if -60 <= azimuth <= 34.75 if upper else -50 <= azimuth <= 50:
                expected.append((float(upper), azimuth))
    np.testing.assert_allclose(fired, expected, atol=1e-9)
    assert counted == pytest.approx(shots_of_110_deg, abs=1e-3)
    assert counted <= SHOTS_MAX


def test_at_50_hz_a_lux_fires_half_as_often_in_a_scan():
    assert [len(shots(single(unit(name)))) for name in ("lux", "lux_50hz")] == [391, 196]


# --- LUX 8L


def libsick_elevation(layer, azimuth, rear, tilt):
    """Return the elevation [rad] of layers 0 to 3 of a mirror face; libsick_ldmrs counts downwards: sign inverted."""
    effective = tilt / 2 * sqrt(2) * sin(azimuth / 2 - pi / 4)
    return -((1.5 - layer) * 0.8 * pi / 180 + (1 if rear else -1) * 2 * effective)


def test_8l_alternates_between_its_mirror_faces():
    table = beam_table(load_rig("srx_six_lux_8l", Path()))
    assert len(table) == 2 * 4692
    for frame, layers in enumerate([{0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 2, 3}]):
        firing = fires(table, frame)
        assert np.bincount(table.unit[firing]).tolist() == [782] * 6
        assert set(table.layer[firing].tolist()) == layers
        np.testing.assert_allclose(table.azimuth[firing], LUX.azimuth, atol=1e-14)
    assert fires(LUX, 0).all()
    assert fires(LUX, 1).all()


def test_8l_directions_equal_those_of_the_sick_driver():
    table = single(unit("lux_8l"))
    tilt = 1.6 * pi / 180
    for layer, azimuth, elevation in zip(table.layer.tolist(), table.azimuth, table.elevation, strict=True):
        assert elevation == pytest.approx(libsick_elevation(layer % 4, azimuth, layer >= 4, tilt), abs=1e-12)
    np.testing.assert_allclose(np.arcsin(table.direction_ego[:, 2]), table.elevation, atol=1e-12)


def test_8l_covers_6_4_degrees_at_its_axis_less_to_the_left_and_more_to_the_right():
    model = unit("lux_8l")
    axis = replace(model, fans=tuple(replace(fan, start_deg=0.0, stop_deg=0.0) for fan in model.fans))
    elevation_deg = np.unique(np.rad2deg(single(axis).elevation).round(9))
    np.testing.assert_allclose(np.diff(elevation_deg), 0.8)
    assert np.ptp(elevation_deg) + 0.8 == pytest.approx(6.4)
    # Between a layer and its counterpart on the other face: 2 x 1.6 deg x sqrt(2) sin(pi / 4 - h / 2).
    table = single(model)
    for azimuth_deg, apart_deg in [(34.75, 2.0984), (0.25, 3.1930), (-59.75, 4.3687)]:
        at = np.isclose(np.rad2deg(table.azimuth), azimuth_deg)
        lower, upper = table.elevation[at & (table.layer == 2)], table.elevation[at & (table.layer == 6)]
        assert np.rad2deg(upper - lower) == pytest.approx([apart_deg], abs=1e-4)


# --- a unit of another kind


def test_the_roof_carries_16_layers_all_around():
    rig = load_rig("roof_spinning_16", Path())
    table = beam_table(rig)
    assert rig.scan_rate_hz == 10.0
    assert len(table) == 16 * 1800
    assert np.unique(np.rad2deg(table.elevation).round(9)).tolist() == list(range(-15, 16, 2))
    one_layer = np.rad2deg(table.azimuth[table.layer == 0])
    np.testing.assert_allclose(np.diff(np.sort(one_layer)), 0.2, atol=1e-9)
    assert one_layer.min() + 360.0 - one_layer.max() == pytest.approx(0.2)
    # A full turn of 100 ms, one firing less.
    assert np.ptp(table.time_offset) == pytest.approx(0.1 * 1799 / 1800)
    np.testing.assert_allclose(table.units.origin_ego, [[0.0, 0.0, 1.90]])
    assert np.all(table.gain == 1.0)


# --- mounting poses


def test_mounts_move_from_the_rear_axle_to_the_ego_frame():
    # Front left: (3.55, 0.75, 0.55) from the rear axle, which is 1.385 m behind the box centre.
    np.testing.assert_allclose(LUX.units.origin_ego[0], [2.165, 0.75, 0.55])
    np.testing.assert_allclose(LUX.units.origin_ego[5], [-2.235, -0.80, 0.60])


def looking(azimuth_deg, **pose):
    """Return the direction in the ego frame of a level beam of a unit with this mount."""
    model = unit("spinning_16")
    fan = replace(model.fans[0], layers=(0,), start_deg=azimuth_deg, stop_deg=azimuth_deg)
    level = replace(model, layer_elevation_deg=(0.0,), layer_bias_m=(0.0,), layer_pulse_bias_m=(0.0,), fans=(fan,))
    return single(level, **pose).direction_ego[0]


def test_positive_pitch_is_down_and_positive_roll_raises_the_left():
    sin10, cos10 = np.sin(np.deg2rad(10)), np.cos(np.deg2rad(10))
    np.testing.assert_allclose(looking(0.0, pitch_deg=10.0), [cos10, 0, -sin10], atol=1e-12)
    np.testing.assert_allclose(looking(90.0, pitch_deg=10.0), [0, 1, 0], atol=1e-12)
    np.testing.assert_allclose(looking(90.0, roll_deg=10.0), [0, cos10, sin10], atol=1e-12)
    # Yaw comes first: a unit that looks left and down pitches about the axis that points backwards.
    np.testing.assert_allclose(looking(0.0, yaw_deg=90.0, pitch_deg=10.0), [0, cos10, -sin10], atol=1e-12)


def test_yaw_pitch_and_roll_are_applied_in_this_order():
    yaw, pitch, roll = np.deg2rad([25.0, -7.0, 4.0])
    about_z = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    about_y = np.array([[np.cos(pitch), 0, np.sin(pitch)], [0, 1, 0], [-np.sin(pitch), 0, np.cos(pitch)]])
    about_x = np.array([[1, 0, 0], [0, np.cos(roll), -np.sin(roll)], [0, np.sin(roll), np.cos(roll)]])
    table = single(unit("lux"), yaw_deg=25.0, pitch_deg=-7.0, roll_deg=4.0)
    np.testing.assert_allclose(table.units.R_ego_unit[0], about_z @ about_y @ about_x, atol=1e-12)
    in_unit = np.column_stack([
        np.cos(table.elevation) * np.cos(table.azimuth),
        np.cos(table.elevation) * np.sin(table.azimuth),
        np.sin(table.elevation),
    ])  # fmt: skip
    np.testing.assert_allclose(table.direction_ego, in_unit @ (about_z @ about_y @ about_x).T, atol=1e-12)
