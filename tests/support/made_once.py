"""Folders that one pytest worker makes, and all read: a test module is often run by two of them."""

import fcntl
import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest


def folder(factory: pytest.TempPathFactory, name: str, make: Callable[[Path], object]) -> Path:
    """Return a folder of the test session; the first caller fills it by `make`, all others wait for that.

    Tests must not change it.
    """
    session = factory.getbasetemp()
    made = (session.parent if "PYTEST_XDIST_WORKER" in os.environ else session) / name
    done = made.with_suffix(".done")
    with made.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not done.exists():
            shutil.rmtree(made, ignore_errors=True)  # of a worker whose `make` failed
            made.mkdir()
            make(made)
            done.touch()
    return made
