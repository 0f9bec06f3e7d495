"""Versions of what can change a result. Light to import."""

import platform
from functools import cache
from importlib.metadata import version

PACKAGES = ("luxloop", "numpy", "numba", "scipy", "filterpy", "trackeval", "libsumo", "highway-env")

Versions = dict[str, str]


@cache
def installed() -> Versions:
    """Versions by name, of what is installed here."""
    return {"python": platform.python_version(), **{package: version(package) for package in PACKAGES}}
