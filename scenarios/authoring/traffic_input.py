"""Traffic from a file, a folder or a name on the command line, with the route files of a net."""

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.files import shipped
from luxloop.sim.highway.environment import environments
from luxloop.sim.highway.highway_config import HighwayTraffic
from luxloop.sim.input_files import DAMAGED, root_element
from luxloop.sim.replay.recording_files import recording_roots
from luxloop.sim.replay.replay_config import ENDINGS, ReplayTraffic
from luxloop.sim.source import TrafficInputError
from luxloop.sim.sumo.input_checks import text_of
from luxloop.sim.sumo.sumo_config import SumoTraffic

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


CONFIGURATIONS = ("sumoConfiguration", "configuration")


@dataclass(frozen=True, slots=True)
class TrafficInput:
    """Traffic that a user names."""

    traffic: SumoTraffic | HighwayTraffic | ReplayTraffic
    folder: Path
    """Folder that relative paths in `traffic` start from."""
    name: str
    """Short name for messages and descriptions."""
    left_out: tuple[str, ...] = ()
    """Files beside a net that were not taken, with the reason."""

    def said_of_left_out(self) -> list[str]:
        """Return a sentence about each file that was not taken."""
        return [f"Left out: {name}." for name in self.left_out]


def read_input(source: str, routes: Sequence[Path] = ()) -> TrafficInput:
    """Return the traffic that a path or a name stands for.

    Parameters
    ----------
    source
        A `.sumocfg`, a net, a folder with one of these, a recording, or the id of an environment of highway-env.
    routes
        Route files of a net, or folders of them; by default those beside it.

    Raises
    ------
    InputError
        The source is unknown, a net has no routes, or other traffic is given some.
    """
    found = _read(source, routes)
    is_net = isinstance(found.traffic, SumoTraffic) and found.traffic.net
    if routes and not is_net and not is_unknown(found.traffic):
        raise InputError(f"--routes {routes[0]}: {source} is no net and has its own traffic; leave it out")
    return found


def is_unknown(traffic: object) -> bool:
    """Return True for an environment that highway-env does not have: any word is read as the id of one."""
    return isinstance(traffic, HighwayTraffic) and traffic.env not in environments()


def refuse_scenario(source: str) -> None:
    """Refuse a scenario, which has its traffic already.

    Raises
    ------
    InputError
        The source is a scenario file, or the name of a shipped scenario and not of an environment.
    """
    is_name = source in shipped.paths() and source not in environments()
    if is_name or (source.endswith(".toml") and os.path.isfile(source)):  # noqa: PTH113  raises for long names
        raise InputError(
            f"{source}: is a scenario {'' if is_name else 'file '}already; start it with luxloop run {source}, or give "
            "the net, configuration or recording that it names"
        )


def _read(source: str, routes: Sequence[Path]) -> TrafficInput:
    """Return the traffic of a source; only a net takes the routes."""
    path = Path(source)
    if os.path.isdir(source):  # noqa: PTH112  Path.is_dir raises for a name that is too long
        path = _only_simulation(path)
    elif not os.path.isfile(source):  # noqa: PTH113  as above
        if os.sep in source or path.suffix in (".xml", ".gz", ".sumocfg", ".csv", ".parquet", ".toml"):
            raise InputError(f"{source}: no such file")
        return TrafficInput(HighwayTraffic(env=source), Path(), source)
    name = path.name.split(".")[0]
    if path.name.endswith((".csv", ".csv.gz", ".parquet")):
        return TrafficInput(ReplayTraffic(file=path.name, ego=""), path.parent, name)
    root = root_of(path)
    if root in CONFIGURATIONS:
        return TrafficInput(SumoTraffic(config=path.name), path.parent, name)
    if root != "net":
        recordings = recording_roots()
        if root in recordings and path.name.endswith(ENDINGS):
            return TrafficInput(ReplayTraffic(file=path.name, ego=""), path.parent, name)
        raise InputError(
            f"{source}: its root is <{root}>; give a SUMO net, a .sumocfg, a recording ({', '.join(recordings)}), "
            "or the id of an environment of highway-env"
        )
    found = files_beside(path, routes)
    if not found.routes and routes:
        raise InputError(
            f"--routes {routes[0]}: has no routes; give a file with the root <routes>, or a folder of such"
        )
    if not found.routes:
        raise InputError(
            f"{source}: no route file beside this net; give one with --routes, or make one with SUMO's randomTrips.py"
        )
    return TrafficInput(
        SumoTraffic(net=path.name, routes=found.routes, additional=found.additional),
        path.parent,
        name,
        tuple(found.left_out),
    )


def root_of(path: Path) -> str:
    """Return the name of the root element of an XML file, which may be compressed.

    Raises
    ------
    InputError
        It is not XML.
    """
    try:
        return root_element(path).tag
    except TrafficInputError as error:
        raise InputError(f"{path}: {error}") from error


def _only_simulation(folder: Path) -> Path:
    """Return the only configuration in a folder, or else its only net."""
    for pattern in ("*.sumocfg", "*.net.xml*"):
        found = sorted(folder.glob(pattern))
        if len(found) > 1:
            raise InputError(f"{folder}: has {', '.join(path.name for path in found)}; name one of them")
        if found:
            return found[0]
    raise InputError(f"{folder}: has no .sumocfg and no .net.xml; name the file")
