"""The beam table against the unit's published numbers, and files that are wrong."""

import re
from pathlib import Path

import numpy as np
import pytest
from support.sensor_scenes import LUX_RIG, one_unit_rig, small_unit

from sensor_model.beams import beam_table
from sensor_model.rig import SHIPPED, RigError, load_rig
from sensor_model.unit import Fan

LUX = beam_table(LUX_RIG)


def test_a_lux_has_790_beams_and_the_rig_4740():
    # 2 layers x 202 beams from +50.25 to -50.25 and 2 x 193 from +36 to -60, every 0.5 degrees (openMSL's LUX 2010).
    assert len(LUX) == 4740
    assert np.bincount(LUX.unit).tolist() == [790] * 6
    assert np.bincount(LUX.layer[LUX.unit == 0]).tolist() == [202, 202, 193, 193]


@pytest.mark.parametrize("unit", range(6))
@pytest.mark.parametrize(
    ("layer", "elevation_deg", "start_deg", "count"),
    [(0, -1.2, 50.25, 202), (1, -0.4, 50.25, 202), (2, 0.4, 36.0, 193), (3, 1.2, 36.0, 193)],
)
def test_every_beam_points_where_the_unit_says(unit, layer, elevation_deg, start_deg, count):
    row = (LUX.unit == unit) & (LUX.layer == layer)
    azimuth_deg = start_deg - 0.5 * np.arange(count)
    np.testing.assert_allclose(np.rad2deg(LUX.azimuth[row]), azimuth_deg, atol=1e-12)
    np.testing.assert_allclose(np.rad2deg(LUX.elevation[row]), elevation_deg, atol=1e-12)
    # With level mounts the ego azimuth is the mount's yaw plus the beam's azimuth.
    yaw_deg = [30, -30, 95, -95, 150, -150][unit]
    x, y, z = LUX.direction_ego[row].T
    turned = np.rad2deg(np.arctan2(y, x)) - yaw_deg - azimuth_deg
    np.testing.assert_allclose((turned + 180) % 360 - 180, 0.0, atol=1e-9)
    np.testing.assert_allclose(np.rad2deg(np.arcsin(z)), elevation_deg, atol=1e-9)


def test_beams_are_numbered_within_their_unit():
    for unit in range(6):
        assert LUX.index[LUX.unit == unit].tolist() == list(range(790))


def test_mounts_move_from_the_rear_axle_to_the_ego_frame():
    # Front left: (3.55, 0.75, 0.55) from the rear axle, which is 1.385 m behind the box centre.
    np.testing.assert_allclose(LUX.origin_ego[0], [2.165, 0.75, 0.55])
    np.testing.assert_allclose(LUX.origin_ego[5], [-2.235, -0.80, 0.60])


@pytest.mark.parametrize(
    ("layer", "azimuth_deg", "percent"),
    [
        # Knots of the published table.
        (2, 36.0, 10), (2, 34.0, 51), (2, 32.0, 69), (2, 25.0, 86), (2, 20.0, 94), (2, 10.0, 100), (2, 0.0, 100),
        (2, -30.0, 100), (2, -40.0, 97), (2, -46.0, 87), (2, -48.0, 84), (2, -50.0, 80), (2, -54.0, 70),
        (2, -56.0, 64), (2, -58.0, 60), (3, -60.0, 43),
        # The lower pair fires between the knots: a quarter degree from each, linear.
        (0, 50.25, 18), (0, 49.75, 18 + 22 * 0.25 / 2), (0, 47.75, 40 + 12 * 0.25 / 2), (1, 45.75, 52 + 9 * 0.25 / 3),
        (1, 42.75, 61 + 3 * 0.25 / 3), (1, 39.75, 64 + 2 * 0.25 / 4), (0, 35.75, 66 + 1 * 0.25 / 2),
        (0, 33.75, 67 + 3 * 0.25 / 2), (0, 31.75, 70 + 14 * 0.25 / 7), (0, 24.75, 84 + 6 * 0.25 / 5),
        (0, 19.75, 90 + 7 * 0.25 / 10), (0, 9.75, 97 + 3 * 0.25 / 10), (0, -0.25, 100),
        (0, -30.25, 100 - 5 * 0.25 / 10),
        (1, -40.25, 95 - 10 * 0.25 / 6), (1, -46.25, 85 - 8 * 0.25 / 2), (1, -48.25, 77 - 42 * 0.25 / 2),
        (1, -50.25, 35 - 35 * 0.25 / 4),
    ],
)  # fmt: skip
def test_gain_follows_the_manual(layer, azimuth_deg, percent):
    beam = (LUX.unit == 3) & (LUX.layer == layer) & (np.abs(np.rad2deg(LUX.azimuth) - azimuth_deg) < 1e-9)
    assert LUX.gain[beam] == pytest.approx([percent / 100])


def test_positive_pitch_looks_down_and_positive_roll_raises_the_left():
    model = small_unit(fans=(Fan((0,), 90.0, 0.0, 90.0, (100.0,)),), elevation_deg=(0.0,))
    left, front = beam_table(one_unit_rig(model, pitch_deg=10.0)).direction_ego
    np.testing.assert_allclose(front, [np.cos(np.deg2rad(10)), 0, -np.sin(np.deg2rad(10))], atol=1e-12)
    np.testing.assert_allclose(left, [0, 1, 0], atol=1e-12)
    left, front = beam_table(one_unit_rig(model, roll_deg=10.0)).direction_ego
    np.testing.assert_allclose(left, [0, np.cos(np.deg2rad(10)), np.sin(np.deg2rad(10))], atol=1e-12)


UNIT = (SHIPPED / "units" / "lux.toml").read_text(encoding="utf-8")
RIG = 'rear_axle_x_m = -1.0\n[[unit]]\nname = "a"\nmodel = "unit.toml"\n' + "".join(
    f"{key} = 0.5\n" for key in ("x_m", "y_m", "z_m", "yaw_deg", "pitch_deg", "roll_deg")
)


def write(folder, rig=RIG, unit=UNIT):
    (folder / "rig.toml").write_text(rig, encoding="utf-8")
    (folder / "unit.toml").write_text(unit, encoding="utf-8")


def test_a_spinning_unit_is_a_file_away(tmp_path):
    elevations = [float(2 * i - 15) for i in range(16)]
    unit = f"""
        range_min_m = 0.5
        range_max_m = 100.0
        pulse_length_m = 1.0
        layer_elevation_deg = {elevations}
        layer_bias_m = {[0.0] * 16}
        gain_azimuth_deg = [0]
        [[fan]]
        layers = {list(range(16))}
        start_deg = 180.0
        stop_deg = -179.8
        step_deg = 0.2
        gain_percent = [100]
    """
    write(tmp_path, unit=unit)
    table = beam_table(load_rig("rig.toml", tmp_path))
    assert len(table) == 16 * 1800
    assert np.all(table.gain == 1.0)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("rear_axle_x_m = -1.0", "rear_axle_x_m = 'back'", r"rig\.toml: rear_axle_x_m = 'back': give a number"),
        ("rear_axle_x_m = -1.0", "", r"rig\.toml: rear_axle_x_m = missing: give a number"),
        ("rear_axle_x_m = -1.0", "rear_axle_x_m = nan", r"rig\.toml: rear_axle_x_m = nan: give a number"),
        ("x_m = 0.5\n", "x_m = true\n", r"rig\.toml: .*x_m = True: give a number"),
        ('name = "a"', "name = 1", r"rig\.toml: unit\[0\]\.name = 1: give a text"),
        ('name = "a"', 'name = "a"\ncolour = 3', r"rig\.toml: unit\[0\]\.colour = 3: unknown key; known here: model"),
        ("unit.toml", "nothing", r"nothing: no such unit file; give a path, or one of: lux"),
        ("[[unit]]", "[[units]]", r"rig\.toml: unit = missing: give at least one \[\[unit\]\] table"),
        ("[[unit]]", "[unit]", r"rig\.toml: unit = .*: give at least one"),
        ("[[unit]]", "[[unit", r"rig\.toml: not readable as TOML .*; correct the file"),
    ],
)
def test_a_wrong_rig_file_is_told_in_one_line(tmp_path, old, new, says):
    assert old in RIG
    write(tmp_path, rig=RIG.replace(old, new))
    with pytest.raises(RigError) as error:
        load_rig("rig.toml", tmp_path)
    assert re.search(says, str(error.value))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("step_deg = 0.5", "step_deg = 0.7", r"unit\.toml: fan\[0\]\.step_deg = 0\.7: must divide"),
        ("step_deg = 0.5", "step_deg = -0.5", r"fan\[0\]\.step_deg = -0\.5: must be positive"),
        ("stop_deg = -50.25", "stop_deg = 60.0", r"fan\[0\]\.stop_deg = 60\.0: must not exceed start_deg"),
        ("stop_deg = -50.25", "stop_deg = -309.75", r"fan\[0\]\.stop_deg = -309\.75: .* less than a full turn"),
        ("layers = [0, 1]", "layers = []", r"fan\[0\]\.layers = \[\]: name at least one layer"),
        ("layers = [2, 3]", "layers = [2, 3.5]", r"fan\[1\]\.layers = \[2, 3\.5\]: give a list of whole numbers"),
        ("layers = [2, 3]", "layers = [2, 4]", r"unit\.toml: layers = \[2, 4\]: layer_elevation_deg has layers 0 to 3"),
        ("range_min_m = 0.3", "range_min_m = 300.0", r"range_min_m = 300\.0: must be at least 0 and below range_max_m"),
        ("pulse_length_m = 1.35", "pulse_length_m = 0", r"pulse_length_m = 0\.0: must be positive"),
        ("0.0165, ", "", r"layer_bias_m = .*: give one number for each of 4 layers"),
        ("[50, 48, 46,", "[50, 48, 49,", r"gain_azimuth_deg = .*: must fall from left to right"),
        ("gain_percent = [18,", "gain_percent = [", r"gain_percent = .*: give one number for each gain_azimuth_deg"),
        ("gain_percent = [18,", "gain_percent = ['x',", r"fan\[0\]\.gain_percent = \['x'.*: give a list of numbers"),
    ],
)
def test_a_wrong_unit_file_is_told_in_one_line(tmp_path, old, new, says):
    assert old in UNIT
    write(tmp_path, unit=UNIT.replace(old, new, 1))
    with pytest.raises(RigError) as error:
        load_rig("rig.toml", tmp_path)
    assert re.search(says, str(error.value))
    assert "\n" not in str(error.value)


def test_an_empty_rig_is_an_error(tmp_path):
    write(tmp_path, rig="rear_axle_x_m = 0.0\nunit = []\n")
    with pytest.raises(RigError, match=r"rig\.toml: unit = \[\]: give at least one \[\[unit\]\] table"):
        load_rig("rig.toml", tmp_path)


def test_an_unknown_rig_lists_the_shipped_ones():
    with pytest.raises(RigError, match=r"no such rig file; give a path, or one of: srx_six_lux"):
        load_rig("srx_seven_lux", Path("somewhere"))
