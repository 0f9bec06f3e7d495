"""Skips of tests whose optional packages are not installed: those of the extras, and oracles of the development."""

import pytest

from luxloop.scenarios.commands.arguments import EXTRAS

PACKAGES = {**EXTRAS, "commonroad": ("commonroad",)}
"""Modules by extra."""
COMMANDS = {"sweep": "sweeps", "thresholds": "sweeps", "search": "search", "mcap": "mcap", "league": "league"}
"""Extras by the commands that need them."""


def need(extra: str, *packages: str) -> None:
    """Skip the test, or the module before its imports, unless packages of an extra are installed; all if left out."""
    for package in packages or PACKAGES[extra]:
        pytest.importorskip(package, reason=f"{package} of the extra luxloop[{extra}] is not installed")


def need_for(command: str) -> None:
    """Skip the test unless the packages of a command are installed, e.g. of `sweep`; others need none."""
    if command in COMMANDS:
        need(COMMANDS[command])
