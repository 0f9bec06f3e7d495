"""What is checked and said before SUMO runs: its files, its command line, its complaints."""

import gzip
import os
import sys
import tempfile
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from sim.source import TrafficInputError

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


def sumo_command(folder: Path, files: dict[str, list[str]], dt: float, seed: int, options: dict[str, str]) -> list[str]:
    """Return SUMO's command line.

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
        Further options, which win over ours.

    Raises
    ------
    TrafficInputError
        A file is missing, or the net is none.
    """
    paths = {option: [_existing(folder / name) for name in names] for option, names in files.items()}
    if "configuration-file" in paths:
        require_net(_net_of(paths["configuration-file"][0]))
    else:
        require_net(paths["net-file"][0])
    words = {option: ",".join(map(str, names)) for option, names in paths.items() if names}
    words |= _QUIET | _ALL_AT_ONCE | {"step-length": str(dt), "seed": str(seed)} | options
    return ["sumo", *(word for option, value in words.items() for word in (f"--{option}", value))]


def require_net(path: Path) -> None:
    """Refuse what is not a net: libsumo 1.28 crashes the whole process on a `<net>` without a version."""
    opened = gzip.open if path.suffix == ".gz" else open
    with opened(_existing(path), "rb") as stream:
        try:
            _, root = next(ET.iterparse(stream, events=("start",)))
        except (ET.ParseError, gzip.BadGzipFile) as error:
            raise TrafficInputError(f"{path}: the net does not parse: {error}") from error
    if root.tag != "net" or "version" not in root.attrib:
        raise TrafficInputError(f"{path}: not a SUMO net (no <net version=...>); make one with netconvert")


@contextmanager
def captured_stderr() -> Iterator[BinaryIO]:
    """Divert the process's stderr, where SUMO's C++ side writes, into a temporary file."""
    sys.stderr.flush()
    terminal = os.dup(2)
    try:
        with tempfile.TemporaryFile() as said:
            os.dup2(said.fileno(), 2)
            try:
                yield said
            finally:
                os.dup2(terminal, 2)
    finally:
        os.close(terminal)


def one_line(complaint: str) -> str:
    """Return SUMO's first error, which may span lines, as one line."""
    first = complaint.strip().removeprefix("Error:").split("Error:")[0]
    return " ".join(first.split())


def _existing(path: Path) -> Path:
    if not path.is_file():
        raise TrafficInputError(f"{path}: no such file; SUMO's files are sought beside the file that names them")
    return path


def _net_of(config: Path) -> Path:
    """Return the path of the net that a `.sumocfg` names."""
    try:
        root = ET.parse(config).getroot()
    except ET.ParseError as error:
        raise TrafficInputError(f"{config}: not a SUMO configuration: {error}") from error
    nets = [entry.get("value", "") for entry in root.iter() if entry.tag in ("net-file", "net", "n")]
    if not nets:
        raise TrafficInputError(f"{config}: no net-file; name the net under <input>")
    return config.parent / nets[0]
