"""Plug-ins: kinds of traffic, file formats and trackers that packages register by entry points, as luxloop itself does.

`docs/own-tracker.md` says how to write one.
"""

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from luxloop.printable import print_text

OWN = "luxloop"
"""Distribution whose plug-ins ship with luxloop."""
GROUPS = ("luxloop.formats", "luxloop.traffic", "luxloop.trackers")


class PluginError(Exception):
    """A plug-in is registered twice or cannot be used. The line names its distribution and its entry point."""


@dataclass(frozen=True, slots=True)
class PluginGroup:
    """A group of entry points.

    Parameters
    ----------
    name
        Name of the group in `[project.entry-points]`.
    check
        Returns what a plug-in of this name and content should be, or an empty text if it is that.
    core
        Members that need no registration. No plug-in can take their names.
    """

    name: str
    check: Callable[[str, Any], str]
    core: Mapping[str, Any] = field(default_factory=dict)

    def names(self, of_luxloop: bool = False) -> list[str]:
        """Return all names, or only those that ship with luxloop: the core's, then the others in alphabetic order."""
        found = {entry.name for entry in _registered(self.name) if not of_luxloop or _distribution(entry) == OWN}
        return [*self.core, *sorted(found - set(self.core))]

    def place(self, name: str) -> str:
        """Return the `MODULE:NAME` of a plug-in.

        Raises
        ------
        PluginError
            It is registered twice.
        """
        if entry := self._entry(name):
            return entry.value
        return f"{self.core[name].__module__}:{self.core[name].__qualname__}"

    def unusable(self, name: str, reason: str) -> PluginError:
        """Return the error that a plug-in of another package cannot be loaded."""
        entry = self._entry(name)
        assert entry
        return PluginError(f"{_described(entry)} cannot be loaded ({reason}); repair or uninstall it")

    def load(self, name: str) -> Any:
        """Import one of `names` and return it.

        Raises
        ------
        PluginError
            It is registered twice, cannot be imported, or is not of the required type.
        """
        entry = self._entry(name)
        if entry is None:
            return self.core[name]
        try:
            found = entry.load()
        except (Exception, SystemExit) as error:  # code of other packages, which may raise anything
            reason = " ".join(f"{type(error).__name__}: {error}".split())
            raise PluginError(f"{_described(entry)} cannot be loaded ({reason}); repair or uninstall it") from error
        if wanted := self.check(name, found):
            raise PluginError(f"{_described(entry)} should be {wanted}; repair or uninstall it")
        return found

    def load_all(self) -> dict[str, Any]:
        """Import all plug-ins and return them by name; a line on standard error names each that cannot be used."""
        found = {}
        for name in self.names():
            try:
                found[name] = self.load(name)
            except PluginError as error:
                _warn(str(error))
        if not any(_distribution(entry) == OWN for entry in _registered(self.name)):
            _warn(f"luxloop's own entry points of {self.name} are not installed; install luxloop again")
        return found

    def _entry(self, name: str) -> EntryPoint | None:
        """Return the only entry point of a name, None for one of the core."""
        entries = [entry for entry in _registered(self.name) if entry.name == name]
        if len(entries) + (name in self.core) > 1:
            other = "luxloop itself" if name in self.core else _described(entries[1])
            raise PluginError(f"{_described(entries[0])} has the name of {other}; uninstall or rename one")
        return entries[0] if entries else None


def distributions() -> dict[str, str]:
    """Return the versions of other packages with plug-ins, by name."""
    entries = [entry for group in GROUPS for entry in _registered(group) if entry.dist and _distribution(entry) != OWN]
    return {entry.dist.name: entry.dist.version for entry in entries if entry.dist}


@cache
def _registered(group: str) -> tuple[EntryPoint, ...]:
    """Return the entry points of a group. The search takes 10 ms."""
    return tuple(entry_points(group=group))


@cache
def _warn(line: str) -> None:
    """Print a line on standard error, once."""
    print_text(f"luxloop: warning: {line}", file=sys.stderr)


def _distribution(entry: EntryPoint) -> str:
    return entry.dist.name if entry.dist else OWN


def _described(entry: EntryPoint) -> str:
    version = f" {entry.dist.version}" if entry.dist else ""
    return f'plug-in {_distribution(entry)}{version} ({entry.group}: {entry.name} = "{entry.value}")'


ABILITIES = ("open_recording", "read_boxes", "read_traffic", "export")
"""Functions of file formats: they read recordings of sensors for `luxloop import`, boxes for `luxloop grade` and
recorded traffic for `kind = "replay"`, and write the folders of `luxloop export`."""


def _wanted_format(_name: str, found: Any) -> str:
    able = any(callable(getattr(found, ability, None)) for ability in ABILITIES)
    return "" if able else f"a module or an object with one of the functions {', '.join(ABILITIES)}"


FORMATS = PluginGroup("luxloop.formats", _wanted_format)
"""File formats: modules or objects that have one or several of `ABILITIES`."""


def formats_that(ability: str) -> dict[str, Any]:
    """Return the formats by name that have one of `ABILITIES`."""
    return {name: found for name, found in FORMATS.load_all().items() if hasattr(found, ability)}
