"""docs/sensor.md and docs/ablation.md: every key is there with its true default, every name, picture and row too."""

import dataclasses
import importlib
import re
import tomllib

import pytest
from support.paths import DOCS

from sensor_model import truth
from sensor_model.noise.noise_config import NoiseConfig
from sensor_model.rig.rig import SHIPPED, load_unit
from sensor_model.sensor_config import SensorConfig

PAGE = (DOCS / "sensor.md").read_text(encoding="utf-8")
ABLATION = (DOCS / "ablation.md").read_text(encoding="utf-8")

_spec = importlib.util.spec_from_file_location("ablation", DOCS / "ablation.py")
ablation = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(ablation)

_spec = importlib.util.spec_from_file_location("draw_sensor", DOCS / "draw_sensor.py")
draw_sensor = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(draw_sensor)

ROWS = dict(re.findall(r"^\| `(\w+(?:\.\w+)+)` \| `([^`]*)` \|", PAGE, flags=re.MULTILINE))
"""Dotted key to its default, as the page's tables have them."""
FILES = {"cast", "visibility"}
"""Modules of `sensor_model` whose constants the page quotes."""


def defaults(config, prefix):
    """Every key of a dataclass by its dotted name; tables within are followed, lists of tables are values."""
    found = {}
    for field in dataclasses.fields(config):
        value = getattr(config, field.name)
        if dataclasses.is_dataclass(value):
            found |= defaults(value, f"{prefix}.{field.name}")
        else:
            found[f"{prefix}.{field.name}"] = plain(value)
    return found


def plain(value):
    """As TOML has it."""
    if dataclasses.is_dataclass(value):
        return dataclasses.asdict(value)
    return [plain(item) for item in value] if isinstance(value, tuple) else value


def test_every_key_of_noise_and_sensor_is_told():
    keys = {*defaults(NoiseConfig(), "noise"), *defaults(SensorConfig(), "sensor")}
    assert {key for key in ROWS if key.startswith(("noise.", "sensor."))} == keys


@pytest.mark.parametrize("key", ROWS)
def test_every_default_is_the_one_in_the_code(key):
    told = tomllib.loads(f"value = {ROWS[key]}")["value"]
    table, _, name = key.partition(".")
    if table == "unit":
        true = plain(getattr(load_unit("lux", SHIPPED), name))
    elif table in FILES:
        true = getattr(importlib.import_module(f"sensor_model.{table}"), name)
    else:
        true = (defaults(NoiseConfig(), "noise") | defaults(SensorConfig(), "sensor"))[key]
    assert told == true


@pytest.mark.parametrize("name", ["Part", "Cause", "Loss", "View"])
def test_every_name_of_the_truth_is_told(name):
    table = re.search(rf"^\| `{name}` \|.*\n(?:\|.*\n)+", PAGE, flags=re.MULTILINE)[0]
    assert re.findall(r"^\| `(\w+)`", table, flags=re.MULTILINE)[1:] == [member.name for member in getattr(truth, name)]


def test_every_field_of_the_truth_is_told():
    for field in dataclasses.fields(truth.ScanTruth):
        assert f"`{field.name}`" in PAGE


def test_every_picture_is_made_and_shown():
    """A picture that no module draws, or that is drawn and not shown, would go stale."""
    shown = set(re.findall(r"pictures/sensor_(\w+)\.png\)", PAGE))
    assert shown == set(draw_sensor.PICTURES)
    for name in draw_sensor.PICTURES:
        assert (DOCS / "sensor_pictures" / f"{name}.py").exists()
        assert (DOCS / "pictures" / f"sensor_{name}.png").stat().st_size < 200_000


def block(name):
    """Rows of a generated table, without its head."""
    table = re.search(rf"<!-- {name} -->\n(.*?)<!-- end -->", ABLATION, flags=re.DOTALL)[1]
    return [[cell.strip() for cell in line.strip("|\n").split("|")] for line in table.splitlines()[2:]]


def test_the_ablation_has_a_row_for_every_kind_of_noise():
    kinds = [field.name for field in dataclasses.fields(NoiseConfig)]
    names = [row[0].strip("`") for row in block("alone")]
    assert names == ["none", *kinds, *(row.name for row in ablation.TOGETHER), ablation.PAPERS_OWN[0]]
    assert [row[0] for row in block("base")] == [row.name for row in ablation.ON_BASE]


def test_the_default_of_the_ablation_is_that_of_the_code():
    """Its name in the table lists what is on: a changed default makes the table stale."""
    on = [field.name for field in dataclasses.fields(NoiseConfig) if getattr(NoiseConfig(), field.name).enabled]
    assert any(row[0] == f"default: {', '.join(on)}" for row in block("alone"))


@pytest.mark.parametrize("name", ["alone", "base", "seeds"])
def test_every_figure_of_the_ablation_is_an_error_in_degrees(name):
    for _, *errors, observations in block(name):
        assert all(0.0 < float(error) < 45.0 for error in errors)
        assert int(observations) > 2000
