"""OpenDRIVE files as nets of SUMO, converted by netconvert of the package eclipse-sumo."""

import os
import shutil
import subprocess
from collections.abc import Mapping
from importlib.util import find_spec
from itertools import takewhile
from pathlib import Path

from luxloop.sim.input_files import missing_file
from luxloop.sim.optional_packages import install_command
from luxloop.sim.source import TrafficInputError
from luxloop.sim.sumo.input_checks import scratch_file
from luxloop.sim.sumo.options import is_rejected

TIMEOUT_S = 600.0
"""[s] Limit of one conversion."""
_ALWAYS = {
    "offset.disable-normalization": "true",  # the net keeps the coordinates of the file
    "xml-validation": "never",  # validation would download schemas
}


def converted(folder: Path, name: str, options: Mapping[str, str]) -> str:
    """Convert an OpenDRIVE file, and return the path of the net.

    Parameters
    ----------
    folder
        Folder of the scenario file.
    name
        Path of the file, relative to it.
    options
        Further options of netconvert by long name.

    Raises
    ------
    TrafficInputError
        netconvert is not installed, cannot read the file, or an option writes files.
    """
    source = folder / name
    if not os.path.isfile(source):  # noqa: PTH113  Path.is_file raises for a name that is too long
        raise TrafficInputError(f'net = "{name}": {missing_file(source)}')
    for option in options:
        if is_rejected(option) or option.endswith(("-file", "-files")):
            raise TrafficInputError(f"netconvert.{option}: options that name files are not supported; remove it")
    program, home = _netconvert()
    net = scratch_file(f"{source.stem}.net.xml")
    words = (f"--{option}={value}" for option, value in {**_ALWAYS, **options}.items())
    command = [program, "--opendrive-files", str(source.absolute()), "--output-file", str(net), *words]
    try:
        run = subprocess.run(
            command,
            capture_output=True,
            text=True,
            errors="replace",
            check=False,
            timeout=TIMEOUT_S,
            env=os.environ | ({"SUMO_HOME": home} if home else {}),
        )
    except subprocess.TimeoutExpired as error:
        raise TrafficInputError(f'net = "{name}": netconvert took more than {TIMEOUT_S:.0f} s') from error
    if run.returncode or not net.exists():
        raise TrafficInputError(f'net = "{name}": netconvert cannot convert it: {_reason(run.stderr)}')
    return str(net)


def _netconvert() -> tuple[str, str]:
    """Return program and data folder of eclipse-sumo, or of a SUMO on the search path."""
    if (package := find_spec("sumo")) and package.submodule_search_locations:
        home = Path(package.submodule_search_locations[0])
        for name in ("netconvert", "netconvert.exe"):
            if (program := home / "bin" / name).exists():
                return str(program), str(home)
    if installed := shutil.which("netconvert"):
        return installed, ""
    raise TrafficInputError(
        f"an OpenDRIVE net needs netconvert of eclipse-sumo, which is not installed: {install_command('opendrive')}"
    )


def _reason(stderr: str) -> str:
    """Return netconvert's first error as one line, with the indented lines after it: often they have the cause."""
    lines = stderr.splitlines()
    first = next((row for row, line in enumerate(lines) if line.startswith("Error: ")), 0)
    more = takewhile(lambda line: line.startswith(" "), lines[first + 1 :])
    message = " ".join([*lines[first : first + 1], *more])
    return " ".join(message.removeprefix("Error: ").split()) or "no message"
