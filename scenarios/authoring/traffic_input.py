"""Traffic from a file, a folder or a name on the command line."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from luxloop.scenarios.authoring.net_folder import RouteFiles, files_beside
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.files import shipped
from luxloop.sim.highway.environment import environments
from luxloop.sim.highway.highway_config import HighwayTraffic
from luxloop.sim.replay.recording_files import recording_roots
from luxloop.sim.replay.replay_config import ENDINGS, ReplayTraffic
from luxloop.sim.source import TrafficInputError
from luxloop.sim.sumo.sumo_config import SumoTraffic
from luxloop.sim.xml_root import root_element

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
    return TrafficInput(_of_net(path, found), path.parent, name, tuple(found.left_out))


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


def _of_net(path: Path, found: RouteFiles) -> SumoTraffic:
    return SumoTraffic(net=path.name, routes=found.routes, additional=found.additional)
