"""Skips of tests whose optional packages are not installed."""

import pytest

from luxloop.scenarios.commands.arguments import EXTRAS

PACKAGES = {**EXTRAS, "commonroad": ("commonroad",)}
"""Modules by extra."""


def need(extra: str) -> None:
    """Skip the test that calls this, directly or by a fixture, unless all packages of an extra are installed."""
    for package in PACKAGES[extra]:
        pytest.importorskip(package, reason=f"the extra luxloop[{extra}] is not installed")
