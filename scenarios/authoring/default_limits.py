"""Generic expectations of a new scenario, from needs and not from results."""

import math
from typing import Any

SCAN_RATE_HZ = 12.5
"""Rate of the default rig."""
SWITCH_PERIOD_S = 5.0
"""[s] Time in which one id switch is tolerated."""


def default_limits(duration_s: float) -> dict[str, dict[str, Any]]:
    """Return the table `[expect]` for a duration [s]."""
    return {
        "sim.ego_collisions": {
            "max": 0,
            "unit": "count",
            "need": "the ground truth is possible: no tracker is right about a vehicle inside the ego",
        },
        "dataset.observations": {
            "min": round(0.5 * SCAN_RATE_HZ * duration_s),
            "unit": "count",
            "need": "a graded vehicle in every second scan on average, else the scene shows little",
        },
        "segmentation.missed_rate": {
            "max": 0.02,
            "unit": "1",
            "need": "a vehicle without a segment is invisible to the planner",
        },
        "track.hota": {
            "min": 0.5,
            "unit": "1",
            "need": "a minimum, below which tracks are useless for driving; the goal for traffic is 0.75",
        },
        "track.id_switches_in_view": {
            "max": math.ceil(duration_s / SWITCH_PERIOD_S),
            "unit": "count",
            "need": f"an id switch restarts a prediction: at most once in {SWITCH_PERIOD_S:g} s",
        },
    }
