"""Options of a `.sumocfg`, without those that write files, open windows or wait for clients.

SUMO does not get the configuration file. Its command line cannot unset options of a configuration, so outputs could
only be redirected, and would still cost time in every step.
"""

import os
import re
import xml.etree.ElementTree as ET
from pathlib import Path

from luxloop.sim.input_files import NOT_XML
from luxloop.sim.source import TrafficInputError

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
"""Full names by synonym, of options that are set here or that name files."""

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
"""Scenario keys by SUMO option; set the key instead of the option."""

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
"""Options that name input files, relative to the configuration."""

_OUTPUT_OPTIONS = re.compile(
    r"""(.+-)? output (\..*)? | .+\.output | output-.+ | save-.+ | C | c | configuration | configuration-file
    | n?dump | dump-.+ | netstate (-.+)? (\..*)? | (person-)?fcd | summary | tripinfo | personinfo
    | personroutes | vehroutes (\..*)? | l | log | log-file | message-log | error-log | device\.(ssm|toc)\.file""",
    re.VERBOSE,
)
"""Options by which SUMO writes files, and their parameters, by name pattern."""

_INTERACTIVE_OPTIONS = re.compile(
    r"""print-options | help | version | V | duration-log\.statistics | remote-port | num-clients
    | gui-.+ | g | quit-on-end | Q | game (\..*)? | G | start | S | delay | d | breakpoints | B
    | edgedata-files | data-files | m | alternative-net-file | N | selection-file | demo | D | disable-textures | T
    | registry-viewport | window-.+ | tracker-interval | osg-.+""",
    re.VERBOSE,
)
"""Options by which SUMO prints to the terminal, waits for clients or configures its window."""


def full_name(option: str) -> str:
    """Return the full name of an option."""
    return _SYNONYMS.get(option, option)


def is_rejected(option: str) -> bool:
    """Return True if an option belongs to output, printing, clients or windows."""
    return bool(_OUTPUT_OPTIONS.fullmatch(option) or _INTERACTIVE_OPTIONS.fullmatch(option))


def configured_options(config: Path) -> dict[str, str]:
    """Return the options of a `.sumocfg` by full name, with absolute paths.

    Raises
    ------
    TrafficInputError
        The file is not a SUMO configuration.
    """
    try:
        root = ET.parse(config).getroot()
    except NOT_XML as error:
        raise TrafficInputError(f"{config}: not a SUMO configuration: {error}") from error
    options = {}
    for entry in root.iter():
        value = entry.get("value", entry.get("v", (entry.text or "").strip()))
        option = full_name(entry.tag)
        if value and not is_rejected(option):
            options[option] = _resolved(config, value) if option in INPUT_FILES else value
    return options


def _resolved(config: Path, names: str) -> str:
    """Resolve comma-separated file names relative to the configuration's folder."""
    expanded = (os.path.expandvars(name.strip()) for name in names.split(","))
    return ",".join(str(config.parent / name) for name in expanded if name)
