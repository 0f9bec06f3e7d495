"""Route files and additional files beside a SUMO net."""

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from luxloop.scenarios.errors import InputError
from luxloop.sim.compressed import DAMAGED
from luxloop.sim.source import TrafficInputError
from luxloop.sim.sumo.input_checks import text_of

_TRAFFIC = re.compile(r"<(vehicle|trip|flow|person|personFlow|container)\b")
_SIGNALS = re.compile(r"<(tlLogic|WAUT)\b")
_SCHEDULE = re.compile(r"<(edgeData|laneData|meandata|timedEvent)\b", re.IGNORECASE)
_TRIP = re.compile(r"<trip\b")
_ID = re.compile(r"""<(?:vehicle|trip|flow|person|personFlow|container)\b[^>]*?\bid\s*=\s*["']([^"']*)["']""")
_ROOT = re.compile(r"<([A-Za-z][\w-]*)")
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
"""SUMO's tools write their whole configuration into a comment at the head."""


@dataclass(slots=True)
class RouteFiles:
    """Files for a net, relative to its folder."""

    routes: list[str] = field(default_factory=list)
    additional: list[str] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)


def files_beside(net: Path, routes: Sequence[Path] = ()) -> RouteFiles:
    """Return the route files and additional files of a net, recognised by their root elements.

    Files of types come before those of vehicles. Of two files with vehicles of the same ids, as the trips and the
    routes that randomTrips.py writes, only the one with routes is taken. Files with signal programs are left out: the
    net has its own, and a second program of the same name is an error.

    Parameters
    ----------
    net
        The net.
    routes
        Route files or folders of them; by default the net's folder.

    Raises
    ------
    InputError
        One of `routes` does not exist, or is no route file.
    """
    found = RouteFiles()
    kinds: dict[str, tuple[str, str]] = {}
    for path in _listed(net, routes):
        text = _text(path)
        head = _ROOT.search(text)
        kinds[os.path.relpath(path, net.parent)] = (head[1] if head else "", text)
    for path in routes:
        root, _ = kinds.get(os.path.relpath(path, net.parent), ("routes", ""))
        if root != "routes":
            raise InputError(f"--routes {path}: its root is <{root}>; give a file with the root <routes>")
    taken = {name for name, (root, _) in kinds.items() if root == "routes" and ".rou.alt." not in name}
    texts = {name: kinds[name][1] for name in taken}
    same = _repeated(texts)
    found.routes = sorted(taken - same.keys(), key=lambda name: (bool(_TRAFFIC.search(texts[name])), name))
    found.left_out = [f"{name}: its vehicles have the same ids as those of {other}" for name, other in same.items()]
    for name, (root, text) in kinds.items():
        if root in ("additional", "add") and not routes:
            if _SIGNALS.search(text):
                found.left_out.append(f"{name}: signal programs beside those of the net")
            elif not _SCHEDULE.search(text):
                found.additional.append(name)
    return found


def _listed(net: Path, routes: Sequence[Path]) -> list[Path]:
    """Return the XML files of folders, and the files themselves."""
    listed: list[Path] = []
    for path in routes or [net.parent]:
        if path.is_dir():
            listed += sorted([*path.glob("*.xml"), *path.glob("*.xml.gz")])
        elif path.is_file():
            listed.append(path)
        else:
            raise InputError(f"--routes {path}: no such file or folder")
    return [path for path in listed if ".net.xml" not in path.name]


def _text(path: Path) -> str:
    """Return the text of a file, or an empty one if it is damaged; SUMO reports that where it is used."""
    try:
        return _COMMENT.sub("", text_of(path))
    except (TrafficInputError, *DAMAGED):
        return ""


def _repeated(texts: dict[str, str]) -> dict[str, str]:
    """Return the files with an id of another file, with that file; files with fewer trips are preferred."""
    taken: dict[str, set[str]] = {}
    repeated: dict[str, str] = {}
    for name in sorted(texts, key=lambda name: (len(_TRIP.findall(texts[name])), name)):
        ids = set(_ID.findall(texts[name]))
        other = next((earlier for earlier, known in taken.items() if not known.isdisjoint(ids)), None)
        if other is None:
            taken[name] = ids
        else:
            repeated[name] = other
    return repeated
