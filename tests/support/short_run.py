"""A scenario of ten frames: a car drives past a standing ego, another stands, and a wall occludes neither."""

import tempfile
from functools import cache
from pathlib import Path

from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.result import Result
from luxloop.scenarios.run import device, loop

FRAMES = 10

TEXT = """\
description = "A car drives past a standing ego [bold], another stands."
seed = 4
duration_s = 0.8

[traffic]
kind = "scripted"

[[traffic.actor]]
x_m = 9
y_m = 3
motion = [{ kind = "straight", speed_mps = 5 }]

[[traffic.actor]]
x_m = -12
y_m = -4
yaw_deg = 30

[[traffic.obstacle]]
corners_m = [[-20, 15], [20, 15]]
height_m = 3
"""


def write(folder: Path, text: str = TEXT, name: str = "short") -> Path:
    """Write a scenario file and return its path."""
    path = folder / f"{name}.toml"
    path.write_text(text, encoding="utf-8")
    return path


def run(text: str = TEXT, factory=None, record_to: Path | None = None, **overrides: object) -> Result:
    """Run a scenario given as text, with the shipped tracker by default."""
    with tempfile.TemporaryDirectory() as folder:
        scenario = Scenario.load(write(Path(folder), text), overrides)
        return loop.run(scenario, factory or device.load(device.SHIPPED), record_to)


@cache
def result() -> Result:
    """Return the result of the short scenario, computed once for all tests that do not change it."""
    return run()
