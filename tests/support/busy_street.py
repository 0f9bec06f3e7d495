"""Short scene in which every stage of the tracker makes errors, and the attribution of these errors."""

import tomllib
from functools import cache
from pathlib import Path

from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.oracle import stage_blame

TEXT = """\
description = "A car in stop-and-go, an oncoming car, and two parked cars with a small gap."
seed = 2
duration_s = 1.6

[traffic]
kind = "scripted"

[traffic.ego]
motion = [{ kind = "straight", speed_mps = 6 }]

[[traffic.actor]]
name = "beside"
x_m = 8
y_m = 3.2
motion = [{ kind = "stop-and-go", peak_speed_mps = 8, go_s = 1.6, stop_s = 0.4 }]

[[traffic.actor]]
name = "oncoming"
x_m = 30
y_m = 6.5
yaw_deg = 180
motion = [{ kind = "straight", speed_mps = 9 }]

[[traffic.actor]]
name = "parked"
x_m = 12
y_m = -4
reflectivity = 0.6

[[traffic.actor]]
name = "parked close"
x_m = 17.2
y_m = -4
reflectivity = 0.6

[[traffic.actor]]
name = "ahead"
x_m = 14
y_m = 0
motion = [{ kind = "straight", speed_mps = 6 }]

[[traffic.obstacle]]
corners_m = [[-20, 12], [40, 12]]
height_m = 3

[noise.outliers]
enabled = true
"""

APART = TEXT.replace("x_m = 17.2\n", "x_m = 24\n").replace("[noise.outliers]\nenabled = true", "[noise]\nideal = true")
"""The parked cars with a larger gap, and no noise."""


def scenario(text: str = TEXT) -> Scenario:
    """Return the scenario of a text, by default of the street."""
    return Scenario.of(tomllib.loads(text), Path("busy.toml"))


@cache
def blamed(text: str = TEXT) -> stage_blame.Blame:
    """Return the blame for the shipped tracker on a street, computed once for all tests that only read it."""
    return stage_blame.find_out(scenario(text))
