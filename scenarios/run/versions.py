"""Versions of the packages that can change a result. Fast to import."""

import platform
from functools import cache
from importlib.metadata import version

from luxloop import plugins
from luxloop.scenarios.errors import InputError

PACKAGES = ("luxloop", "numpy", "numba", "scipy", "filterpy", "libsumo", "highway-env")

Versions = dict[str, str]


@cache
def installed() -> Versions:
    """Return the installed versions by package name, Python's first and those of plug-ins last."""
    return _found() | plugins.distributions()


def require_unchanged() -> None:
    """Check that the packages still have the versions of `installed`.

    Raises
    ------
    InputError
        A package was installed or removed meanwhile: parts of the run may be of either version.
    """
    before, now = installed(), _found()
    for package, found in now.items():
        if before[package] != found:
            raise InputError(f"{package} {before[package]} was replaced by {found} during the run; run it again")


def _found() -> Versions:
    return {"python": platform.python_version(), **{package: version(package) for package in PACKAGES}}
