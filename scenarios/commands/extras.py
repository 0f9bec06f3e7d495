"""Optional packages, by the extra of luxloop that installs them."""

from importlib.util import find_spec

from luxloop.scenarios.errors import InputError
from luxloop.sim.optional_packages import install_command

EXTRAS = {
    "sweeps": ("dask", "distributed", "fsspec"),
    "search": ("dask", "distributed", "fsspec", "optuna", "tomli_w"),
    "mcap": ("mcap", "mcap_ros2"),
    "osi": ("betterosi", "mcap"),
    "recordings": ("rosbags", "mcap", "mcap_ros2"),
    "league": ("stonesoup", "norfair"),
}
"""Modules by extra, as in `pyproject.toml`. `commonroad` is checked where it is imported, in `sim.commonroad`; `tests`
and `docs` serve other programs than luxloop."""


def require(command: str, extra: str) -> None:
    """Check that the packages of an extra are installed, before a command starts.

    Raises
    ------
    InputError
        A package is missing.
    """
    for package in EXTRAS[extra]:
        if find_spec(package) is None:
            missing = f"luxloop {command} needs {package}, which is not installed"
            raise InputError(f"{missing}: {install_command(extra)}")


def require_of(command: str, plugin: object) -> None:
    """Check that the packages of a plug-in of luxloop are installed; its `EXTRA` names their extra.

    Raises
    ------
    InputError
        A package is missing.
    """
    if extra := getattr(plugin, "EXTRA", ""):
        require(command, extra)
