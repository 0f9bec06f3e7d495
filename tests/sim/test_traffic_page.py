"""docs/traffic.md: limits and environments match the code, and the example runs."""

import dataclasses
import math
import re

import pytest
from support.paths import DOCS
from support.traffic import documented_environments, registered_environments

from luxloop.sim.modes import ModeLimits
from luxloop.sim.physical import limits

PAGE = (DOCS / "traffic.md").read_text(encoding="utf-8")
LIMITS = re.findall(r"^\| `([A-Z_]+)` \| ([\d.]+) (\S+)", PAGE, flags=re.MULTILINE)


@pytest.mark.parametrize(("name", "value", "unit"), LIMITS, ids=[name for name, *_ in LIMITS])
def test_limits_of_bodies_match_the_code(name, value, unit):
    true = getattr(limits, name)
    assert float(value) == pytest.approx(math.degrees(true) if unit == "degrees" else true, abs=1e-12)


def test_limits_of_modes_match_their_defaults():
    documented = dict(re.findall(r"^\| `(\w+_mps2?)` \| ([\d.]+) m", PAGE, flags=re.MULTILINE))
    assert {name: float(value) for name, value in documented.items()} == dataclasses.asdict(ModeLimits())


def test_every_environment_is_documented_once():
    assert documented_environments() == registered_environments()


def test_the_example_runs(capsys):
    (code,) = re.findall(r"^```python\n(.*?)^```", PAGE, flags=re.DOTALL | re.MULTILINE)
    exec(compile(code, "traffic.md", "exec"), {})
    velocity = re.findall(r"[\d.]+", capsys.readouterr().out)[:2]
    assert math.hypot(*map(float, velocity)) == pytest.approx(10.0, abs=0.1)  # as commanded
