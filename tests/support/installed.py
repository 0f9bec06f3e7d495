"""luxloop as users have it: built and installed into environments of their own, without network."""

import os
import shutil
import subprocess
import sysconfig
from pathlib import Path

from support.paths import ROOT

FOLDERS = ("scenarios", "sensor_model", "sim", "tracker")
"""Folders of the checkout that are installed as packages of luxloop."""
INSTALLED = os.pathsep.join({sysconfig.get_path("purelib"), sysconfig.get_path("platlib")})
"""Folders with the packages that luxloop needs; its own editable checkout is named by a file that is not read there."""


def environment(**more: str) -> dict[str, str]:
    """Return the environment of a user's shell: without variables of pytest, and of the Python path of the tests."""
    own = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST_", "PYTHON", "GITHUB_"))}
    return {**own, "PIP_NO_INDEX": "1", "PIP_DISABLE_PIP_VERSION_CHECK": "1", **more}


def run_checked(command: list[str], folder: Path, **more: str) -> str:
    """Run a command in a folder with `environment`, and return its standard output."""
    run = subprocess.run(command, cwd=folder, env=environment(**more), capture_output=True, text=True, check=False)
    assert run.returncode == 0, f"{command}\n{run.stdout}\n{run.stderr}"
    return run.stdout


def copy_kernels(site_packages: Path) -> None:
    """Copy the compiled kernels of the checkout to an installed luxloop: the sources are equal."""
    for folder in FOLDERS:
        for kernel in (ROOT / folder).rglob("__pycache__/*.nb[ic]"):
            copy = site_packages / "luxloop" / kernel.relative_to(ROOT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(kernel, copy)
