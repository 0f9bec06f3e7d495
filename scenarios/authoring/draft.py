"""Draft of a scenario file: its options, content and default limits."""

import math
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from luxloop.scenarios.authoring.ego_survey import WINDOW_S
from luxloop.scenarios.errors import InputError
from luxloop.sim.candidates.want import Want

_Paths = TypeVar("_Paths", str, list[str])


@dataclass(frozen=True, slots=True)
class DraftOptions:
    """Options of a new scenario."""

    out: Path
    """The scenario file."""
    duration_s: float
    seed: int
    want: Want
    ego: str
    """Id of the ego; empty to choose it."""
    begin_s: float | None
    """[s] Start of SUMO's clock."""
    window_s: float
    """[s] Time that is surveyed."""

    def refuse(self, why: str, *names: str) -> None:
        """Refuse options that some traffic has no use for.

        Parameters
        ----------
        why
            End of the message.
        names
            The options: `--ego`, `--begin`, `--want`, `--window`.

        Raises
        ------
        InputError
            One of them is not at its default.
        """
        changed = {
            "--ego": bool(self.ego),
            "--begin": self.begin_s is not None,
            "--want": self.want is not Want.NEIGHBOURS,
            "--window": self.window_s != WINDOW_S,
        }
        given = [name for name in names if changed[name]]
        if given:
            raise InputError(f"{' and '.join(given)}: {why}")

    def moved(self, names: _Paths, folder: Path) -> _Paths:
        """Return file names relative to `folder` as names relative to the scenario file."""
        if isinstance(names, str):
            return os.path.relpath(folder / names, self.out.parent) if names else names
        return [self.moved(name, folder) for name in names]


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


@dataclass(frozen=True, slots=True)
class Draft:
    """Choice of traffic, ego and window, before it is checked."""

    description: str
    traffic: dict[str, Any]
    """The table `[traffic]`."""
    duration_s: float
    seed: int
    choices: list[str] = field(default_factory=list)
    """Choices with their reasons, a sentence each."""

    def document(self) -> dict[str, Any]:
        """Return the content of the scenario file."""
        return {
            "description": self.description,
            "reason": "Written by luxloop new. Say here where the situation occurs, and which errors it reveals.",
            "seed": self.seed,
            "duration_s": self.duration_s,
            "traffic": self.traffic,
            "expect": default_limits(self.duration_s),
        }
