"""The trackers of the league, by name."""

import hashlib
import importlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.files import toml_file
from luxloop.scenarios.run.device import SHIPPED, Device
from luxloop.tracker.tracker import TrackerConfig

PARAMETERS = Path(__file__).parent / "parameters.toml"
REFERENCE = "shipped"
"""The tracker that the others are compared with."""


@dataclass(frozen=True, slots=True)
class Entrant:
    """A tracker of the league; a `luxloop.scenarios.run.device.DeviceFactory`."""

    name: str
    place: str
    """MODULE:NAME."""
    text: str
    """Association and filter."""
    settings: Mapping[str, Any] = field(default_factory=dict)

    def __call__(self, config: TrackerConfig, **others: Any) -> Device:
        """Make the tracker; `others` replace its settings."""
        module, _, name = self.place.rpartition(":")
        device: Device = getattr(importlib.import_module(module), name)(config, **{**self.settings, **others})
        return device

    def __str__(self) -> str:
        return self.name

    @property
    def digest(self) -> str:
        """Digest of the settings."""
        text = json.dumps({"place": self.place, **self.settings}, sort_keys=True)
        return hashlib.blake2b(text.encode(), digest_size=6).hexdigest()


_TRACKERS = "luxloop.scenarios.league.trackers"
_PLACES = {
    REFERENCE: (SHIPPED, "the shipped tracker"),
    "paper": (f"{_TRACKERS}.paper_variant:paper_variant", "the paper's own steps"),
    "nearest-neighbour": (f"{_TRACKERS}.nearest_neighbour:NearestNeighbour", "Stone Soup: GNN, Kalman filter"),
    "jpda": (f"{_TRACKERS}.joint_probabilistic:JointProbabilistic", "Stone Soup: JPDA, Kalman filter"),
    "autoware-bicycle": (f"{_TRACKERS}.autoware_bicycle:AutowareBicycle", "Autoware's fit, Hungarian, two-axle EKF"),
    "norfair": (f"{_TRACKERS}.norfair_points:NorfairPoints", "norfair-enough: greedy, Kalman filter"),
    "particle-filter": (f"{_TRACKERS}.particle_filter:ParticleFilter", "Stone Soup: GNN, particle filter"),
    "multi-hypothesis": (f"{_TRACKERS}.multi_hypothesis:MultiHypothesis", "Stone Soup: multi-frame assignment"),
}


@cache
def entrants() -> dict[str, Entrant]:
    """Return all trackers with their tuned settings, the reference first."""
    tuned = toml_file.read(PARAMETERS)
    return {name: Entrant(name, place, text, tuned.get(name, {})) for name, (place, text) in _PLACES.items()}


def chosen(names: Sequence[str]) -> list[Entrant]:
    """Return these trackers, all if there are none; the reference is always one of them.

    Raises
    ------
    InputError
        A name is unknown.
    """
    known = entrants()
    for name in names:
        if name not in known:
            raise InputError(
                f"--trackers {name or 'of an empty name'}: no such tracker; give some of {', '.join(known)}"
            )
    return [each for name, each in known.items() if not names or name in names or name == REFERENCE]
