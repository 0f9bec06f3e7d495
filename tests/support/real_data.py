"""Folder of the real recordings, which are not part of the project."""

import os
from pathlib import Path

import pytest

VARIABLE = "LUXLOOP_REAL_DATA"


def real_file(name):
    """Return the path of a real recording; skip the test where the recordings are absent."""
    folder = os.environ.get(VARIABLE)
    if not folder:
        pytest.skip(f"{VARIABLE} is not set: it names the folder of the real recordings")
    path = Path(folder) / name
    if not path.is_file():
        pytest.skip(f"{path}: no such recording")
    return path
