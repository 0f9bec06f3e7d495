"""Checks of SUMO's input files, and its command line."""

import functools
import os
import re
import tempfile
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from pathlib import Path

from luxloop.sim.input_files import DAMAGED, open_detected, root_element
from luxloop.sim.source import TrafficInputError
from luxloop.sim.sumo.options import INPUT_FILES, SCENARIO_KEYS, configured_options, full_name, is_rejected

_READ_ROUTES_FIRST = {"route-steps": "0"}
"""Read route files completely at the start. By default SUMO reads them incrementally, and drops vehicles that are not
in order of departure with only a warning."""

_QUIET = {
    "no-step-log": "true",
    "no-warnings": "true",
    "verbose": "false",
    "duration-log.disable": "true",
    # validation would download schemas
    "xml-validation": "never",
    "xml-validation.net": "never",
    "xml-validation.routes": "never",
}

_UP_TO_THE_ROOT = "../" * 64

_GEOGRAPHIC = re.compile(r"""<poly\s[^>]*?\sgeo\s*=\s*["'](1|true|yes|on|t|x)["']""", re.IGNORECASE)
_UNPROJECTED = re.compile(r"""<location\s[^>]*?projParameter\s*=\s*["']!["']""")


def sumo_command(
    folder: Path,
    files: dict[str, list[str]],
    dt: float,
    seed: int,
    options: dict[str, str],
    begin_s: float | None = None,
) -> list[str]:
    """Return SUMO's command line, which suppresses or redirects all of its output.

    Parameters
    ----------
    folder
        Folder that relative paths start from.
    files
        File names by option: `configuration-file`, or `net-file`, `route-files` and `additional-files`.
    dt
        Step length [s].
    seed
        SUMO's seed.
    options
        Further options. They take precedence over the fixed ones, and those over the configuration.
    begin_s
        Start of the simulation [s]; None takes the configuration's or SUMO's default.

    Raises
    ------
    TrafficInputError
        A file is missing, the net is invalid, or an option is not supported.
    """
    paths = {option: [_resolved(folder, option, name) for name in names] for option, names in files.items() if names}
    options_given = {option: ",".join(map(str, names)) for option, names in paths.items()}
    if "configuration-file" in options_given:
        options_given = _from_configuration(paths["configuration-file"][0])
    require_net(Path(options_given["net-file"]))
    _require_projection(Path(options_given["net-file"]), options_given.get("additional-files", ""))
    ours = {"step-length": str(dt), "seed": str(seed), "random": "false"}
    if begin_s is not None:
        ours["begin"] = str(begin_s)
    values = options_given | _QUIET | _READ_ROUTES_FIRST | ours | _checked_options(options)
    if values.get("mesosim", "false") not in ("false", "0", "no", "off", "f"):
        raise TrafficInputError("mesosim: a mesoscopic simulation has no positions on the road; remove the option")
    values["output-prefix"] = _scratch_prefix()
    return ["sumo", *(word for option, value in values.items() for word in (f"--{option}", value))]


def require_net(path: Path) -> None:
    """Reject a file that is not a net: libsumo 1.28 crashes the process on a `<net>` without a version."""
    root = _net_root(_require_file(path))
    if root.tag != "net" or "version" not in root.attrib:
        raise TrafficInputError(f"{path}: not a SUMO net (no <net version=...>); make one with netconvert")


def _require_projection(net: Path, additional: str) -> None:
    """Reject polygons in longitude and latitude on a net without a projection: SUMO would treat degrees as metres."""
    geographic = [name for name in additional.split(",") if name and _GEOGRAPHIC.search(text_of(Path(name)))]
    if geographic and _UNPROJECTED.search(text_of(net)):
        raise TrafficInputError(
            f'{geographic[0]}: polygons with geo="true", but {net.name} has no projection; '
            "convert them with polyconvert, or import the net with its projection"
        )


def is_left_hand(command: Sequence[str]) -> bool:
    """Return True if traffic keeps to the left on the net of a command line by `sumo_command`."""
    (net,) = input_files(command, ["net-file"])
    return _net_root(net).get("lefthand", "false") in ("true", "1")


def input_files(command: Sequence[str], options: Sequence[str] = ("route-files", "additional-files")) -> list[Path]:
    """Return the files that a command line by `sumo_command` lists under `options`."""
    values = dict(zip(command[1::2], command[2::2], strict=True))
    return [Path(name) for option in options for name in values.get(f"--{option}", "").split(",") if name]


def _from_configuration(config: Path) -> dict[str, str]:
    options_given = configured_options(config)
    if "net-file" not in options_given:
        raise TrafficInputError(f"{config}: no net-file; name the net under <input>")
    for option in sorted(INPUT_FILES & options_given.keys()):
        for name in options_given[option].split(","):
            _require_file(Path(name))
    return options_given


def _checked_options(options: dict[str, str]) -> dict[str, str]:
    """Return the scenario's options by full name; reject unsupported ones."""
    for option in options:
        if is_rejected(option):
            raise TrafficInputError(f"options.{option}: output and interactive options are not supported; remove it")
    return {full_name(option): value for option, value in options.items()}


def clean_up() -> None:
    """Remove redirected output of SUMO. Call this after closing SUMO, since the process may be killed later."""
    if _scratch.cache_info().currsize:
        _scratch().cleanup()
        _scratch.cache_clear()


def scratch_file(name: str) -> Path:
    """Return the path of a file that exists until `clean_up` or the end of the process."""
    return Path(_scratch().name) / name


@functools.cache
def _scratch() -> "tempfile.TemporaryDirectory[str]":
    """Return a folder that exists until `clean_up` or the end of the process."""
    return tempfile.TemporaryDirectory(prefix="luxloop-")


def _scratch_prefix() -> str:
    """Return a prefix for file names that redirects any path to a scratch folder.

    Detectors in additional files and devices of vehicle types name output files that no option disables. SUMO inserts
    its `output-prefix` between folder and file name. A prefix of enough `../` to reach the root, followed by the path
    of the scratch folder, therefore redirects any folder.
    """
    return f"{_UP_TO_THE_ROOT}{_scratch().name.lstrip('/')}/"


def text_of(path: Path) -> str:
    """Return the text of a file, which may be compressed.

    Raises
    ------
    TrafficInputError
        The compressed file is damaged, or expands too much.
    """
    with open_detected(path) as stream:
        try:
            return stream.read().decode(errors="replace")
        except DAMAGED as error:
            raise TrafficInputError(f"{path}: not a complete file: {error}") from error


def _net_root(net: Path) -> ET.Element:
    try:
        return root_element(net)
    except TrafficInputError as error:
        raise TrafficInputError(f"{net}: the net is {error}") from error


def _resolved(folder: Path, option: str, name: str) -> Path:
    """Return the path of a file named in a scenario; an error names the scenario key."""
    try:
        return _require_file(folder / name)
    except TrafficInputError as error:
        raise TrafficInputError(f'{SCENARIO_KEYS[option]} = "{name}": {error}') from error


def _require_file(path: Path) -> Path:
    if not os.path.isfile(path):  # noqa: PTH113  Path.is_file raises for a name that is too long
        if os.path.isdir(path):  # noqa: PTH112  as above
            raise TrafficInputError(f"{path}: is a folder; name a file in it")
        raise TrafficInputError(f"{path}: no such file; paths are relative to the file that contains them")
    return path
