"""Message for a path of a scenario that is no file."""

import os
from pathlib import Path


def missing_file(path: Path) -> str:
    """Return why a path that is no file cannot be read, with the remedy. It does not name the path."""
    if os.path.isdir(path):  # noqa: PTH112  Path.is_dir raises for a name that is too long
        return "is a folder; name a file in it"
    return f"no such file in {path.parent}; paths are relative to the scenario file"
