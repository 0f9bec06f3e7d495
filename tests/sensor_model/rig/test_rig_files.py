"""Rig and unit files: shipped files, documentation page, and errors."""

import re
from pathlib import Path

import numpy as np
import pytest
from support.pages import chapter

from luxloop.sensor_model.rig.beams import beam_table
from luxloop.sensor_model.rig.rig import SHIPPED, RigError, load_rig, load_unit

PAGE = chapter("scenario-files.md", "Rig and unit files")
RIGS = sorted(path.stem for path in (SHIPPED / "rigs").glob("*.toml"))
UNITS = sorted(path.stem for path in (SHIPPED / "units").glob("*.toml"))

POSE = "".join(f"{key} = 0.5\n" for key in ("x_m", "y_m", "z_m", "yaw_deg", "pitch_deg", "roll_deg"))
RIG = f'rear_axle_x_m = -1.0\n[[unit]]\nname = "a"\nmodel = "unit.toml"\n{POSE}'
UNIT = (SHIPPED / "units" / "lux.toml").read_text(encoding="utf-8")


def write(folder, rig=RIG, unit=UNIT):
    (folder / "rig.toml").write_text(rig, encoding="utf-8")
    (folder / "unit.toml").write_text(unit, encoding="utf-8")


def error_message(folder):
    """Return the one-line error of the rig in the folder."""
    with pytest.raises(RigError) as error:
        load_rig("rig.toml", folder)
    assert "\n" not in str(error.value)
    return str(error.value)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("z_m = 0.5", "z_m = 0.0", "z_m = 0.0: must be positive"),
        ('name = "a"', 'name = "*"', "reserved for all units"),
        ('name = "a"', 'name = "a"\nphase_ms = 1e5', "at most one scan"),
        ("[[unit]]", f'[[unit]]\nname = "a"\nmodel = "unit.toml"\n{POSE}[[unit]]', "used by another unit"),
    ],
)
def test_impossible_mounts_are_refused(tmp_path, old, new, message):
    write(tmp_path, rig=RIG.replace(old, new, 1))
    assert message in error_message(tmp_path)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("echoes_max = 3", "echoes_max = 100000000000"),
        ("reference_range_m = 50.0", "reference_range_m = 1e200"),
        ("reference_range_m = 50.0", "reference_range_m = 1e-200"),
        ("range_max_m = 200.0", "range_max_m = 1e300"),
        ("layer_elevation_deg = [-1.2, -0.4, 0.4, 1.2]", "layer_elevation_deg = [-120, -60, 60, 90]"),
    ],
)
def test_units_with_extreme_values_are_refused(tmp_path, old, new):
    assert old in UNIT
    write(tmp_path, unit=UNIT.replace(old, new, 1))
    assert new.partition(" ")[0] in error_message(tmp_path)


# --- the page


def examples():
    return re.findall(r"^```toml\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)


def keys_in(title):
    """Return the keys of the table under a heading of the page."""
    section = re.search(rf"^##+ {re.escape(title)}\n(.*?)(?=^##|\Z)", PAGE, re.DOTALL | re.MULTILINE)[1]
    return re.findall(r"^\| `(\w+)` \|", section, re.MULTILINE)


def shipped_in(title):
    """Return name, and last column as a number, of each row of the table with that heading."""
    table = re.search(rf"^\| {title} \|.*\n\|[-|]+\n((?:\|.*\n)+)", PAGE, re.MULTILINE)[1]
    return {
        row.split("|")[1].strip(" `"): int(row.split("|")[-2].replace(" ", "")) for row in table.strip().splitlines()
    }


def test_custom_sensor_of_the_page_works(tmp_path):
    unit, rig, choice, *_ = examples()
    (tmp_path / "my_unit.toml").write_text(unit, encoding="utf-8")
    (tmp_path / re.search(r'file = "(.*)"', choice)[1]).write_text(rig, encoding="utf-8")
    table = beam_table(load_rig("my_rig.toml", tmp_path))
    assert np.bincount(table.unit).tolist() == [2 * (60 + 241 + 60)] * 2
    np.testing.assert_allclose(table.units.origin_ego, [[0.0, 0.9, 0.6], [0.0, -0.9, 0.6]])
    assert table.gain[0] == pytest.approx(0.5)
    assert table.time_offset.max() == pytest.approx(0.040 + 0.25 * 0.080)


def test_variants_of_shipped_files_on_the_page_work(tmp_path):
    *_, rig, unit = examples()
    (tmp_path / "rig.toml").write_text(rig, encoding="utf-8")
    (tmp_path / "unit.toml").write_text(unit, encoding="utf-8")
    assert load_rig("rig.toml", tmp_path).scan_rate_hz == 25.0
    reference, lux = load_unit("unit.toml", tmp_path), load_unit("lux", tmp_path)
    assert (reference.reference_range_m, lux.reference_range_m) == (60.0, 50.0)
    assert reference.fans == lux.fans


@pytest.mark.parametrize(
    ("title", "file", "first_key"),
    [
        ("Keys of a rig", "rig", "rear_axle_x_m"),
        ("`[[unit]]`", "rig", "name"),
        ("Keys of a unit", "unit", "scan_rate_hz"),
        ("`[[fan]]`", "unit", "layers"),
    ],
)
def test_page_lists_every_key(tmp_path, title, file, first_key):
    """The error of an unknown key lists the known ones."""
    text = {"rig": RIG, "unit": UNIT}
    text[file] = re.sub(rf"^{first_key}", f"unknown_key = 1\n{first_key}", text[file], count=1, flags=re.MULTILINE)
    write(tmp_path, **text)
    known = re.search(r"unknown_key = 1: unknown key; known here: (.*)", error_message(tmp_path))[1]
    assert sorted(keys_in(title)) == known.split(", ")


def test_page_lists_the_shipped_files():
    rigs, units = shipped_in("rig"), shipped_in("unit")
    assert sorted(rigs) == RIGS
    assert sorted(units) == UNITS
    for name, beams in rigs.items():
        assert per_scan(load_rig(name, Path())) == beams, name
    for name, beams in units.items():
        model = load_unit(name, Path())
        assert sum(fan.count * len(fan.layers) for fan in model.fans) / model.turns == beams, name


def per_scan(rig):
    return sum(fan.count * len(fan.layers) / mount.model.turns for mount in rig.mounts for fan in mount.model.fans)


# --- variants


def test_mount_may_have_another_model_than_its_rig(tmp_path):
    mounts = f'model = "lux"\n[[unit]]\nname = "a"\n{POSE}[[unit]]\nname = "b"\nmodel = "unit.toml"\n{POSE}'
    write(tmp_path, rig=f"rear_axle_x_m = 0\n{mounts}", unit='like = "lux"\nrange_max_m = 90.0')
    assert [mount.model.range_max_m for mount in load_rig("rig.toml", tmp_path).mounts] == [200.0, 90.0]


def test_mounts_are_in_phase_by_default(tmp_path):
    write(tmp_path)
    assert load_rig("rig.toml", tmp_path).mounts[0].phase_ms == 0.0
    write(tmp_path, rig=f"{RIG}phase_ms = -12.5\n")
    assert load_rig("rig.toml", tmp_path).mounts[0].phase_ms == -12.5


def test_variants_of_the_rig_have_its_mounts():
    def poses(name):
        return [(mount.name, mount.x_m, mount.y_m, mount.z_m, mount.yaw_deg) for mount in load_rig(name, Path()).mounts]

    assert poses("srx_six_lux_8l") == poses("srx_six_lux_flexres") == poses("srx_six_lux")


# --- invalid files


@pytest.mark.parametrize(
    ("old", "new", "pattern"),
    [
        ("rear_axle_x_m = -1.0", "rear_axle_x_m = 'back'", r"rig\.toml: rear_axle_x_m = 'back': give a number"),
        ("rear_axle_x_m = -1.0", "", r"rig\.toml: rear_axle_x_m = missing: give a number"),
        ("rear_axle_x_m = -1.0", "rear_axle_x_m = nan", r"rig\.toml: rear_axle_x_m = nan: give a number"),
        ("x_m = 0.5\n", "x_m = true\n", r"rig\.toml: .*x_m = True: give a number"),
        ("x_m = 0.5\n", "x_m = 0.5\nphase_ms = 'late'\n", r"unit\[0\]\.phase_ms = 'late': give a number"),
        ('name = "a"', "name = 1", r"rig\.toml: unit\[0\]\.name = 1: give a string"),
        ('name = "a"', 'name = "a"\ncolour = 3', r"rig\.toml: unit\[0\]\.colour = 3: unknown key; known here: model"),
        ('model = "unit.toml"', "", r"rig\.toml: unit\[0\]\.model = missing: give a string"),
        ("unit.toml", "nothing", r"nothing: no such unit file; give a path, or one of: lux, lux_25hz"),
        ("[[unit]]", "[[units]]", r"rig\.toml: unit = missing: give at least one \[\[unit\]\] table"),
        ("[[unit]]", "[unit]", r"rig\.toml: unit = .*: give at least one"),
        ("[[unit]]", "[[unit", r"rig\.toml: not readable as TOML .*; correct the file"),
        (
            "rear_axle_x_m",
            "like = 'srx_six'\nrear_axle_x_m",
            r"srx_six: no such rig file; give a path, or one of: roof",
        ),
        (
            "rear_axle_x_m",
            "like = 'srx_six_lux_8l'\nrear_axle_x_m",
            r"rig\.toml: like = 'srx_six_lux_8l': this rig is based on 'srx_six_lux' itself; name that one",
        ),
    ],
)
def test_invalid_rig_file_gives_a_one_line_error(tmp_path, old, new, pattern):
    assert old in RIG
    write(tmp_path, rig=RIG.replace(old, new))
    assert re.search(pattern, error_message(tmp_path))


@pytest.mark.parametrize(
    ("old", "new", "pattern"),
    [
        ("step_deg = 0.5", "step_deg = 0.7", r"unit\.toml: fan\[0\]\.step_deg = 0\.7: must divide"),
        ("step_deg = 0.5", "step_deg = -0.5", r"fan\[0\]\.step_deg = -0\.5: must be at least 0\.001"),
        ("step_deg = 0.5", "step_deg = 5e-324", r"fan\[0\]\.step_deg = 5e-324: must be at least 0\.001"),
        ("stop_deg = -50.0", "stop_deg = 60.0", r"fan\[0\]\.stop_deg = 60\.0: must not exceed start_deg"),
        ("stop_deg = -50.0", "stop_deg = -309.5", r"fan\[0\]\.stop_deg = -309\.5: azimuths are from -180 to 180"),
        ("start_deg = 50.0", "start_deg = 270.0", r"fan\[0\]\.start_deg = 270\.0: azimuths are from -180 to 180"),
        (
            "start_deg = 50.0\nstop_deg = -50.0",
            "start_deg = 180\nstop_deg = -180",
            r"fan\[0\]\.stop_deg = -180\.0: .* less than a full turn; end one step earlier",
        ),
        ("layers = [0, 1]", "layers = []", r"fan\[0\]\.layers = \[\]: name at least one layer"),
        ("layers = [0, 1]", "layers = [0, 0]", r"fan\[0\]\.layers = \[0, 0\]: name each layer once"),
        ("layers = [2, 3]", "layers = [2, 3.5]", r"fan\[1\]\.layers = \[2, 3\.5\]: give a list of whole numbers"),
        ("layers = [2, 3]", "layers = [2, 4]", r"unit\.toml: layers = \[2, 4\]: layer_elevation_deg has layers 0 to 3"),
        ("layers = [2, 3]", "layers = [-1, 3]", r"layers = \[-1, 3\]: layer_elevation_deg has layers 0 to 3"),
        ("layers = [0, 1]", "layers = [0, 1]\nturn = 1", r"unit\.toml: turn = 1: must be 0 to 0; turns = 1"),
        ("layers = [0, 1]", "layers = [0, 1]\nturn = -1", r"turn = -1: must be 0 to 0"),
        ("layers = [0, 1]", "layers = [0, 1]\nturn = 0.5", r"fan\[0\]\.turn = 0\.5: give a whole number"),
        ("layers = [0, 1]", "layers = [0, 1]\ntilt_deg = 'up'", r"fan\[0\]\.tilt_deg = 'up': give a number"),
        ("scan_rate_hz = 12.5", "scan_rate_hz = 0", r"unit\.toml: scan_rate_hz = 0\.0: must be positive"),
        ("scan_rate_hz = 12.5", "scan_rate_hz = 12.5\nturns = 0", r"turns = 0: must be positive"),
        ("scan_rate_hz = 12.5", "scan_rate = 12.5", r"scan_rate_hz = missing: give a number"),
        ("range_min_m = 0.3", "range_min_m = 300.0", r"range_min_m = 300\.0: must be below range_max_m"),
        ("range_min_m = 0.3", "range_min_m = -0.3", r"range_min_m = -0\.3: must not be negative"),
        ("beam_width_deg = 0.08", "beam_width_deg = -0.08", r"beam_width_deg = -0\.08: must be positive"),
        ("beam_height_deg = 0.784", "beam_height_deg = 0", r"beam_height_deg = 0\.0: must be positive"),
        ("reference_reflectivity = 0.1", "reference_reflectivity = 0", r"reference_reflectivity = 0\.0: must be pos"),
        ("reference_range_m = 50.0", "reference_range_m = -50", r"reference_range_m = -50\.0: must be positive"),
        ("pulse_length_m = 0.675", "pulse_length_m = 0", r"pulse_length_m = 0\.0: must be positive"),
        ("pulse_growth_m_per_db = 0.032", "pulse_growth_m_per_db = -1", r"pulse_growth_m_per_db = -1\.0: must not be"),
        ("pulse_quantum_m = 0.04", "pulse_quantum_m = 0", r"pulse_quantum_m = 0\.0: must be positive"),
        ("range_quantum_m = 0.01", "range_quantum_m = 0", r"range_quantum_m = 0\.0: must be positive"),
        ("range_sigma_m = 0.015", "range_sigma_m = -0.015", r"range_sigma_m = -0\.015: must not be negative"),
        (
            "range_sigma_far_m = 0.025",
            "range_sigma_far_m = 0.01",
            r"range_sigma_far_m = 0\.01: must be at least",
        ),
        ("pulse_sigma_m = 0.09", "pulse_sigma_m = -1", r"pulse_sigma_m = -1\.0: must not be negative"),
        ("echoes_max = 3", "echoes_max = 0", r"echoes_max = 0: must be positive"),
        ("echoes_max = 3", "echoes_max = 2.5", r"echoes_max = 2\.5: give a whole number"),
        ("echo_separation_m = 5.0", "echo_separation_m = -1", r"echo_separation_m = -1\.0: must not be negative"),
        ("[-1.2, -0.4,", "[-0.4, -1.2,", r"layer_elevation_deg = \[-0\.4, -1\.2, .*: must rise; layer 0 is the"),
        ("[-1.2, -0.4, 0.4, 1.2]", "[]", r"layer_elevation_deg has 0 numbers: give 1 to 256"),
        ("0.009, ", "", r"unit\.toml: layer_bias_m = .*: give one number for each of 4 layers"),
        ("-0.31, ", "", r"layer_pulse_bias_m = .*: give one number for each of 4 layers"),
        (" 50, 49, 48,", " 50, 49, 51,", r"gain_azimuth_deg = .*: must fall from left to right"),
        ("  4, 10,", " 10,", r"gain_percent = \[10.*: give one number for each gain_azimuth_deg"),
        (" 4, 10,", " -4, 10,", r"fan\[0\]\.gain_percent = \[-4.*: must not be negative"),
        (" 4, 10,", " 'x', 10,", r"unit\.toml: gain_percent\.lower = \['x'.*: give a list of numbers"),
        ("[gain_percent]", "[gain]", r"unit\.toml: gain_percent = missing: give a \[gain_percent\] table"),
        ('gain = "upper"', 'gain = "top"', r"fan\[1\]\.gain = 'top': no such column; .* has: lower, upper"),
        (
            "scan_rate_hz = 12.5",
            "like = 'lux_8l'",
            r"like = 'lux_8l': this unit is based on 'lux' itself; name that one",
        ),
    ],
)
def test_invalid_unit_file_gives_a_one_line_error(tmp_path, old, new, pattern):
    assert old in UNIT
    write(tmp_path, unit=UNIT.replace(old, new, 1))
    assert re.search(pattern, error_message(tmp_path))


def test_rig_with_two_scan_rates_is_an_error(tmp_path):
    write(tmp_path, rig=f'{RIG}[[unit]]\nname = "b"\nmodel = "lux_25hz"\n{POSE}')
    assert re.search(
        r"rig\.toml: unit\[1\]\.model: scan_rate_hz = 25\.0, but unit\[0\] has 12\.5: choose", error_message(tmp_path)
    )


def test_empty_rig_is_an_error(tmp_path):
    write(tmp_path, rig="rear_axle_x_m = 0.0\nunit = []\n")
    assert re.search(r"rig\.toml: unit = \[\]: give at least one \[\[unit\]\] table", error_message(tmp_path))


def test_error_of_an_unknown_rig_lists_the_shipped_ones():
    with pytest.raises(RigError, match=r"no such rig file; give a path, or one of: roof_spinning_16, srx_six_lux"):
        load_rig("srx_seven_lux", Path("somewhere"))
