"""What is checked before SUMO runs: its files and its command line."""

import functools
import gzip
import os
import re
import tempfile
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from pathlib import Path
from typing import BinaryIO, cast

from sim.source import TrafficInputError
from sim.sumo.options import INPUT_FILES, SCENARIO_KEYS, configured, full_name, left_out

_ALL_AT_ONCE = {"route-steps": "0"}
"""Read route files to their end first. By default SUMO reads them as it goes, and drops vehicles that are out of the
order of departure with no more than a warning."""

_QUIET = {
    "no-step-log": "true",
    "no-warnings": "true",
    "verbose": "false",
    "duration-log.disable": "true",
    # validation would fetch schemas from the network
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
    """Return SUMO's command line. With it SUMO writes nothing beside its input, whatever that asks for.

    Parameters
    ----------
    folder
        Folder that relative paths start from.
    files
        File names by the option that takes them: `configuration-file`, or `net-file`, `route-files` and
        `additional-files`.
    dt
        Step length [s].
    seed
        SUMO's seed.
    options
        Further options, which win over ours, as ours do over those of a configuration.
    begin_s
        When the simulation begins [s], None for the configuration's or SUMO's own.

    Raises
    ------
    TrafficInputError
        A file is missing, the net is none, or an option asks for what cannot be had.
    """
    paths = {option: [_named(folder, option, name) for name in names] for option, names in files.items() if names}
    given = {option: ",".join(map(str, names)) for option, names in paths.items()}
    if "configuration-file" in given:
        given = _from_configuration(paths["configuration-file"][0])
    require_net(Path(given["net-file"]))
    _require_projection(Path(given["net-file"]), given.get("additional-files", ""))
    ours = {"step-length": str(dt), "seed": str(seed), "random": "false"}
    if begin_s is not None:
        ours["begin"] = str(begin_s)
    words = given | _QUIET | _ALL_AT_ONCE | ours | _acceptable(options)
    if words.get("mesosim", "false") not in ("false", "0", "no", "off", "f"):
        raise TrafficInputError("mesosim: a mesoscopic simulation has no positions on the road; take the option out")
    words["output-prefix"] = _out_of_the_way()
    return ["sumo", *(word for option, value in words.items() for word in (f"--{option}", value))]


def require_net(path: Path) -> None:
    """Refuse what is not a net: libsumo 1.28 crashes the whole process on a `<net>` without a version."""
    root = _root(_existing(path))
    if root.tag != "net" or "version" not in root.attrib:
        raise TrafficInputError(f"{path}: not a SUMO net (no <net version=...>); make one with netconvert")


def _require_projection(net: Path, additional: str) -> None:
    """Refuse polygons in longitude and latitude on a net without a projection: SUMO takes degrees for metres."""
    geographic = [name for name in additional.split(",") if name and _GEOGRAPHIC.search(text_of(Path(name)))]
    if geographic and _UNPROJECTED.search(text_of(net)):
        raise TrafficInputError(
            f'{geographic[0]}: polygons with geo="true", but {net.name} has no projection; '
            "convert them with polyconvert, or import the net with its projection"
        )


def is_left_hand(command: Sequence[str]) -> bool:
    """Whether traffic keeps to the left on the net that the command line of `sumo_command` names."""
    (net,) = input_files(command, ["net-file"])
    return _root(net).get("lefthand", "false") in ("true", "1")


def input_files(command: Sequence[str], options: Sequence[str] = ("route-files", "additional-files")) -> list[Path]:
    """Return the files that the command line of `sumo_command` names under `options`."""
    values = dict(zip(command[1::2], command[2::2], strict=True))
    return [Path(name) for option in options for name in values.get(f"--{option}", "").split(",") if name]


def _from_configuration(config: Path) -> dict[str, str]:
    given = configured(config)
    if "net-file" not in given:
        raise TrafficInputError(f"{config}: no net-file; name the net under <input>")
    for option in sorted(INPUT_FILES & given.keys()):
        for name in given[option].split(","):
            _existing(Path(name))
    return given


def _acceptable(options: dict[str, str]) -> dict[str, str]:
    """Return the scenario's own options by full name; refuse those that a run has no use for."""
    for option in options:
        if left_out(option):
            raise TrafficInputError(f"options.{option}: SUMO writes no files and waits for nobody here; take it out")
    return {full_name(option): value for option, value in options.items()}


def clean_up() -> None:
    """Remove what SUMO wrote out of the way; to be called once it is closed, as its process may be killed later."""
    if _scratch.cache_info().currsize:
        _scratch().cleanup()
        _scratch.cache_clear()


@functools.cache
def _scratch() -> "tempfile.TemporaryDirectory[str]":
    """Return a folder that is there until `clean_up`, or goes with the process."""
    return tempfile.TemporaryDirectory(prefix="luxloop-")


def _out_of_the_way() -> str:
    """Return a prefix for file names that leads from any folder to a scratch folder.

    Detectors in additional files, and devices of vehicle types, name files of their own, which no option switches
    off. SUMO sets its `output-prefix` between folder and name, so that as many steps up as it takes and a path from
    the root down make any folder the scratch folder.
    """
    return f"{_UP_TO_THE_ROOT}{_scratch().name.lstrip('/')}/"


def text_of(path: Path) -> str:
    """Return what a file holds that may be compressed."""
    with _opened(path) as stream:
        return stream.read().decode(errors="replace")


def _opened(path: Path) -> BinaryIO:
    """Open a file as SUMO does, which tells compressed ones by how they begin."""
    with path.open("rb") as stream:
        compressed = stream.read(2) == b"\x1f\x8b"
    return cast(BinaryIO, gzip.open(path)) if compressed else path.open("rb")


def _root(net: Path) -> ET.Element:
    """Return the first element of a net, without its children."""
    with _opened(net) as stream:
        try:
            root: ET.Element = next(ET.iterparse(stream, events=("start",)))[1]
        except (ET.ParseError, gzip.BadGzipFile, EOFError) as error:
            raise TrafficInputError(f"{net}: the net does not parse: {error}") from error
    return root


def _named(folder: Path, option: str, name: str) -> Path:
    """Return the path of a file that a scenario names; a complaint tells by which key it does."""
    try:
        return _existing(folder / name)
    except TrafficInputError as error:
        raise TrafficInputError(f'{SCENARIO_KEYS[option]} = "{name}": {error}') from error


def _existing(path: Path) -> Path:
    if not os.path.isfile(path):  # noqa: PTH113  Path.is_file raises for a name that is too long
        raise TrafficInputError(f"{path}: no such file; SUMO's files are sought beside the file that names them")
    return path
