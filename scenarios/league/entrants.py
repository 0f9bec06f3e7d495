"""The trackers of the league, by name: plug-ins of the group `luxloop.trackers`, and the shipped tracker."""

import hashlib
import importlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.run.device import REFERENCE, SHIPPED, TRACKERS, Device
from luxloop.scenarios.study import run_content
from luxloop.tracker.tracker import TrackerConfig


@dataclass(frozen=True, slots=True)
class Entrant:
    """A tracker of the league; a `luxloop.scenarios.run.device.DeviceFactory`."""

    name: str
    place: str
    """MODULE:NAME."""
    text: str
    """Association and filter."""
    settings: Mapping[str, Any] = field(default_factory=dict)
    extra: str = ""
    """Extra of luxloop that installs its packages."""

    def __call__(self, config: TrackerConfig, **others: Any) -> Device:
        """Make the tracker; `others` replace its settings."""
        module, _, name = self.place.rpartition(":")
        device: Device = getattr(importlib.import_module(module), name)(config, **{**self.settings, **others})
        return device

    def __str__(self) -> str:
        return self.name

    @property
    def digest(self) -> str:
        """Digest of the settings, and of the code of a tracker that does not ship with luxloop."""
        own = self.place.startswith("luxloop.")  # `drive_scans.code_digest` has its code
        code = {} if own else {"code": run_content.of_tracker(self.place)}
        text = json.dumps({"place": self.place, **code, **self.settings}, sort_keys=True)
        return hashlib.blake2b(text.encode(), digest_size=6).hexdigest()


@cache
def entrants() -> dict[str, Entrant]:
    """Return all trackers that are installed, the reference first."""
    found = {name: _entrant(name, tracker) for name, tracker in TRACKERS.load_all().items()}
    return {**found, REFERENCE: Entrant(REFERENCE, SHIPPED, "the shipped tracker")}


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


def _entrant(name: str, tracker: Any) -> Entrant:
    """Return a plug-in as an entrant, described by the first line of its docstring."""
    if isinstance(tracker, Entrant):
        return tracker
    lines = (tracker.__doc__ or "").strip().splitlines()
    return Entrant(name, TRACKERS.place(name), lines[0].rstrip(".") if lines else "")
