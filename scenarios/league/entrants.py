"""The trackers of the league: plug-ins of the group `luxloop.trackers`, the shipped tracker, and the user's own."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from luxloop.scenarios.errors import DeviceError, InputError
from luxloop.scenarios.run import device
from luxloop.scenarios.run.device import REFERENCE, SHIPPED, TRACKERS, Device, DeviceFactory
from luxloop.scenarios.run.process_tracker import PREFIX, ClassFactory
from luxloop.scenarios.study import run_content
from luxloop.tracker.tracker import TrackerConfig


@dataclass(frozen=True, slots=True)
class Entrant:
    """A tracker of the league."""

    name: str
    place: str
    """MODULE:NAME, or FILE.py:NAME or process:COMMAND with absolute paths."""
    text: str
    """Association and filter."""
    settings: Mapping[str, Any] = field(default_factory=dict)
    extra: str = ""
    """Extra of luxloop that installs its packages."""
    is_own: bool = False
    """True for a tracker that is named by its place."""

    @property
    def spec(self) -> str:
        """Text that chooses the tracker."""
        return self.place if self.is_own else self.name

    def __call__(self, config: TrackerConfig, **others: Any) -> Device:
        """Make the tracker; `others` replace its settings."""
        make: Any = device.load(self.place, in_process=True)
        made: Device = make(config, **{**self.settings, **others})
        return made

    @property
    def factory(self) -> DeviceFactory:
        """Factory of the tracker; that of the user runs in a process of its own."""
        return device.load(self.place) if self.is_own else self

    def __str__(self) -> str:
        return self.name

    @property
    def digest(self) -> str:
        """Digest of the settings, and of the code of a tracker that does not ship with luxloop."""
        shipped = self.place.startswith("luxloop.")  # `drive_scans.code_digest` has its code
        code = {} if shipped else {"code": run_content.of_tracker(self.place)}
        text = json.dumps({"place": self.place, **code, **self.settings}, sort_keys=True)
        return hashlib.blake2b(text.encode(), digest_size=6).hexdigest()


@cache
def entrants() -> dict[str, Entrant]:
    """Return all trackers that are installed, the reference first."""
    found = {name: _entrant(name, tracker) for name, tracker in TRACKERS.load_all().items()}
    return {**found, REFERENCE: Entrant(REFERENCE, SHIPPED, "the shipped tracker")}


def chosen(specs: Sequence[str]) -> list[Entrant]:
    """Return these trackers by names and places, all named ones if there are none; the reference is always one of them.

    Raises
    ------
    InputError
        A name is unknown, a tracker of one's own cannot be loaded, or two have the same name.
    """
    known, own = entrants(), [_own(spec) for spec in specs if ":" in spec]
    for name in (spec for spec in specs if ":" not in spec):
        if name not in known:
            raise InputError(
                f"--trackers {name or 'of an empty name'}: no such tracker; give some of {', '.join(known)}, "
                "or one of your own as MODULE:NAME, FILE.py:NAME or process:COMMAND"
            )
    named = [each for name, each in known.items() if not specs or name in specs or name == REFERENCE]
    names = [each.name for each in (*known.values(), *own)]
    for each in own:
        if names.count(each.name) > 1:
            raise InputError(f"--trackers {each.place}: another tracker is named {each.name}, too; rename one of them")
    return [*named, *own]


@cache
def _own(spec: str) -> Entrant:
    """Load a tracker of the user's once, and describe it by the first line of its docstring."""
    try:
        tracker = device.load(spec)
    except DeviceError as error:
        raise InputError(str(error).replace("--tracker ", "--trackers ", 1)) from error
    place = device.absolute(spec)
    if not spec.startswith(PREFIX):
        text = tracker.documentation if isinstance(tracker, ClassFactory) else _first_line(tracker)
        return Entrant(device.short_name(spec), place, text.rstrip("."), is_own=True)
    words = spec.removeprefix(PREFIX).split()
    script = next((word for word in words if word.endswith(".py")), words[0])  # all run by `python` need other names
    return Entrant(Path(script).name, place, place, is_own=True)


def _first_line(tracker: Any) -> str:
    lines = (tracker.__doc__ or "").strip().splitlines()
    return lines[0].rstrip(".") if lines else ""


def _entrant(name: str, tracker: Any) -> Entrant:
    """Return a plug-in as an entrant, described by the first line of its docstring."""
    if isinstance(tracker, Entrant):
        return tracker
    return Entrant(name, TRACKERS.place(name), _first_line(tracker))
