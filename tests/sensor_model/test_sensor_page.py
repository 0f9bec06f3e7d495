"""docs/sensor.md and the ablation of docs/tracker.md: completeness of keys, defaults, names and rows."""

import dataclasses
import importlib
import re
import tomllib

import pytest
from blocks import ablation
from support.pages import block
from support.paths import DOCS

from luxloop.sensor_model import truth
from luxloop.sensor_model.noise.noise_config import KINDS, NoiseConfig
from luxloop.sensor_model.rig.rig import SHIPPED, load_unit
from luxloop.sensor_model.sensor_config import SensorConfig

PAGE = (DOCS / "sensor.md").read_text(encoding="utf-8")


ROWS = dict(re.findall(r"^\| `(\w+(?:\.\w+)+)` \| `([^`]*)` \|", PAGE, flags=re.MULTILINE))
"""Dotted key to its default, from the tables of the page."""
FILES = {"raycaster", "visibility"}
"""Modules of `sensor_model` with constants on the page."""


def defaults(config, prefix):
    """Return the keys of a dataclass by dotted name; nested tables are expanded, lists of tables are values."""
    found = {}
    for field in dataclasses.fields(config):
        value = getattr(config, field.name)
        if dataclasses.is_dataclass(value):
            found |= defaults(value, f"{prefix}.{field.name}")
        else:
            found[f"{prefix}.{field.name}"] = plain(value)
    return found


def plain(value):
    """Return a value in TOML syntax."""
    if dataclasses.is_dataclass(value):
        return dataclasses.asdict(value)
    return [plain(item) for item in value] if isinstance(value, tuple) else value


def test_every_key_of_noise_and_sensor_is_documented():
    keys = {*defaults(NoiseConfig(), "noise"), *defaults(SensorConfig(), "sensor")}
    assert {key for key in ROWS if key.startswith(("noise.", "sensor."))} == keys


@pytest.mark.parametrize("key", ROWS)
def test_documented_defaults_equal_the_code(key):
    documented = tomllib.loads(f"value = {ROWS[key]}")["value"]
    table, _, name = key.partition(".")
    if table == "unit":
        true = plain(getattr(load_unit("lux", SHIPPED), name))
    elif table in FILES:
        true = getattr(importlib.import_module(f"luxloop.sensor_model.{table}"), name)
    else:
        true = (defaults(NoiseConfig(), "noise") | defaults(SensorConfig(), "sensor"))[key]
    assert documented == true


@pytest.mark.parametrize("name", ["Part", "Cause", "Loss", "View"])
def test_every_member_of_the_truth_is_documented(name):
    table = re.search(rf"^\| `{name}` \|.*\n(?:\|.*\n)+", PAGE, flags=re.MULTILINE)[0]
    assert re.findall(r"^\| `(\w+)`", table, flags=re.MULTILINE)[1:] == [member.name for member in getattr(truth, name)]


def test_every_field_of_the_truth_is_documented():
    for field in dataclasses.fields(truth.ScanTruth):
        assert f"`{field.name}`" in PAGE


def test_the_ablation_has_a_row_for_every_kind_of_noise_and_today_s_default():
    """The row of the default lists the enabled kinds: a changed default makes the table stale."""
    rows = block(DOCS / "tracker.md", "alone").splitlines()[2:]
    names = [row.strip("| ").split(" | ")[0].strip("`") for row in rows]
    assert names == ["none", *KINDS, *ablation.TOGETHER, "the paper's recordings"]
