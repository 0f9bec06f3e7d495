"""docs/traffic.md: limits, environments and pictures match the code, and the example runs."""

import dataclasses
import importlib.util
import math
import re

import gymnasium
import highway_env  # noqa: F401  registers its environments
import pytest
from support.paths import DOCS

from sim.modes import ModeLimits
from sim.physical import limits

PAGE = (DOCS / "traffic.md").read_text(encoding="utf-8")
LIMITS = re.findall(r"^\| `([A-Z_]+)` \| ([\d.]+) (\S+)", PAGE, flags=re.MULTILINE)

_spec = importlib.util.spec_from_file_location("draw_motion", DOCS / "draw_motion.py")
draw_motion = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(draw_motion)


@pytest.mark.parametrize(("name", "value", "unit"), LIMITS, ids=[name for name, *_ in LIMITS])
def test_limits_of_bodies_match_the_code(name, value, unit):
    true = getattr(limits, name)
    assert float(value) == pytest.approx(math.degrees(true) if unit == "degrees" else true, abs=1e-12)


def test_limits_of_modes_match_their_defaults():
    documented = dict(re.findall(r"^\| `(\w+_mps2?)` \| ([\d.]+) m", PAGE, flags=re.MULTILINE))
    assert {name: float(value) for name, value in documented.items()} == dataclasses.asdict(ModeLimits())


def test_every_environment_is_documented_once():
    registered = [name for name, spec in gymnasium.registry.items() if str(spec.entry_point).startswith("highway_env.")]
    (table,) = re.findall(r"^\| environments \|.*\n((?:\|.*\n)+)", PAGE, flags=re.MULTILINE)
    assert sorted(re.findall(r"`([\w-]+-v\d)`", table)) == sorted(registered)


def test_the_example_runs(capsys):
    (code,) = re.findall(r"^```python\n(.*?)^```", PAGE, flags=re.DOTALL | re.MULTILINE)
    exec(compile(code, "traffic.md", "exec"), {})
    velocity = re.findall(r"[\d.]+", capsys.readouterr().out)[:2]
    assert math.hypot(*map(float, velocity)) == pytest.approx(10.0, abs=0.1)  # as commanded


def test_every_picture_has_its_module():
    assert {f"motion_{name}.png" for name in draw_motion.PICTURES} == {
        path.name for path in (DOCS / "pictures").glob("motion_*.png")
    }
    for name in (*draw_motion.PICTURES, draw_motion.FIGURES):
        assert (DOCS / "motion_pictures" / f"{name}.py").is_file()
