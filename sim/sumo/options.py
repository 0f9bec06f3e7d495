"""A `.sumocfg`, read for its options: those that write files, open windows or wait for clients are left out.

SUMO itself is not given the configuration. Options that are set cannot be unset on its command line, so its outputs
could at best be diverted, and would still cost their time in every step.
"""

import os
import re
import xml.etree.ElementTree as ET
from pathlib import Path

from sim.source import TrafficInputError

_SYNONYMS = {
    "n": "net-file",
    "net": "net-file",
    "r": "route-files",
    "routes": "route-files",
    "a": "additional-files",
    "additional": "additional-files",
    "w": "weight-files",
    "weights": "weight-files",
    "b": "begin",
    "e": "end",
    "s": "route-steps",
    "srand": "seed",
    "abs-rand": "random",
    "v": "verbose",
    "t": "duration-log.statistics",
    "no-duration-log": "duration-log.disable",
    "W": "no-warnings",
    "suppress-warnings": "no-warnings",
    "X": "xml-validation",
    "device.fcd-replay.file": "device.fcd-replay.files",
}
"""Other names of options that are ours to set, or that name files."""

SCENARIO_KEYS = {
    "configuration-file": "config",
    "net-file": "net",
    "route-files": "routes",
    "additional-files": "additional",
    "begin": "begin_s",
    "step-length": "dt_s",
    "seed": "seed",
    "random": "seed",
}
"""Scenario keys by the SUMO option that they stand for, which is not to be set beside them."""

INPUT_FILES = frozenset(
    {
        "net-file",
        "route-files",
        "additional-files",
        "weight-files",
        "load-state",
        "device.ssm.filter-edges.input-file",
        "device.fcd-replay.files",
        "astar.all-distances",
        "astar.landmark-distances",
        "pedestrian.jupedsim.wkt",
    }
)
"""Options that name files to read, relative to the configuration."""

_WRITES = re.compile(
    r"""(.+-)? output (\..*)? | .+\.output | output-.+ | save-.+ | C | c | configuration | configuration-file
    | n?dump | dump-.+ | netstate (-.+)? (\..*)? | (person-)?fcd | summary | tripinfo | personinfo
    | personroutes | vehroutes (\..*)? | l | log | log-file | message-log | error-log | device\.(ssm|toc)\.file""",
    re.VERBOSE,
)
"""Options by which SUMO writes files, or that say how: by what they end on, or by their other names."""

_TALKS = re.compile(
    r"""print-options | help | version | V | duration-log\.statistics | remote-port | num-clients
    | gui-.+ | g | quit-on-end | Q | game (\..*)? | G | start | S | delay | d | breakpoints | B
    | edgedata-files | data-files | m | alternative-net-file | N | selection-file | demo | D | disable-textures | T
    | registry-viewport | window-.+ | tracker-interval | osg-.+""",
    re.VERBOSE,
)
"""Options by which SUMO talks on the terminal, waits for clients or sets up its window."""


def full_name(option: str) -> str:
    """Return the name under which an option is known here."""
    return _SYNONYMS.get(option, option)


def left_out(option: str) -> bool:
    """Whether an option makes SUMO write a file, talk or wait, or says how to."""
    return bool(_WRITES.fullmatch(option) or _TALKS.fullmatch(option))


def configured(config: Path) -> dict[str, str]:
    """Return the options that a `.sumocfg` sets, by full name, paths made absolute.

    Raises
    ------
    TrafficInputError
        It is not a SUMO configuration.
    """
    try:
        root = ET.parse(config).getroot()
    except ET.ParseError as error:
        raise TrafficInputError(f"{config}: not a SUMO configuration: {error}") from error
    options = {}
    for entry in root.iter():
        value = entry.get("value", entry.get("v", (entry.text or "").strip()))
        option = full_name(entry.tag)
        if value and not left_out(option):
            options[option] = _beside(config, value) if option in INPUT_FILES else value
    return options


def _beside(config: Path, names: str) -> str:
    """Resolve comma-separated file names from the configuration's folder."""
    expanded = (os.path.expandvars(name.strip()) for name in names.split(","))
    return ",".join(str(config.parent / name) for name in expanded if name)
