"""Scenario files, run loop, grading, recording and the command line."""

import sys
from importlib import import_module
from pathlib import Path


def _import_own_packages() -> None:
    """Import luxloop's other packages before a folder of the user can take their names.

    `tracker` and `sim` are common folder names, and the current folder may come first on the path (`python -m pytest`).
    Imported packages stay: everything later, in workers as well, takes them from `sys.modules`.
    """
    home = str(Path(__file__).parents[1])
    sys.path.insert(0, home)
    try:
        for package in ("sensor_model", "sim", "tracker"):
            import_module(package)
    finally:
        sys.path.remove(home)


_import_own_packages()
