"""Versions of the packages that can change a result. Fast to import."""

import platform
from functools import cache
from importlib.metadata import version

PACKAGES = ("luxloop", "numpy", "numba", "scipy", "filterpy", "libsumo", "highway-env")

Versions = dict[str, str]


@cache
def installed() -> Versions:
    """Return the installed versions by package name, Python's first."""
    return {"python": platform.python_version(), **{package: version(package) for package in PACKAGES}}
