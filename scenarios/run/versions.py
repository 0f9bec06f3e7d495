"""Versions of the packages that can change a result. Fast to import."""

import platform
from functools import cache
from importlib.metadata import version

from luxloop import plugins

PACKAGES = ("luxloop", "numpy", "numba", "scipy", "filterpy", "libsumo", "highway-env")

Versions = dict[str, str]


@cache
def installed() -> Versions:
    """Return the installed versions by package name, Python's first and those of plug-ins last."""
    packages = {package: version(package) for package in PACKAGES}
    return {"python": platform.python_version(), **packages, **plugins.distributions()}
