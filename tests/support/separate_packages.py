"""Packages whose requirements exclude those of the development environment, each in a folder of its own.

osi-python needs a newer protobuf than commonroad-io; ouster-sdk pins old versions of psutil, click and rosbags. The
folders are made in the virtual environment when a test needs one, and used again until their lock changes.
"""

import fcntl
import hashlib
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDERS = Path(sys.prefix) / "separate"


def folder_of(name):
    """Folder with the packages of `constraints-NAME.txt`, to be put on the path of a process."""
    lock = ROOT / f"constraints-{name}.txt"
    folder = FOLDERS / f"{name}-{hashlib.sha256(lock.read_bytes()).hexdigest()[:12]}"
    FOLDERS.mkdir(exist_ok=True)
    with (FOLDERS / f"{name}.lock").open("w") as turn:
        fcntl.flock(turn, fcntl.LOCK_EX)  # the other workers of pytest-xdist wait for the first
        if not folder.is_dir():
            _install(lock, folder)
    return folder


def append_to_path(name):
    """Let this process import the packages, after those of the environment."""
    folder = str(folder_of(name))
    if folder not in sys.path:
        sys.path.append(folder)


def _install(lock, folder):
    with tempfile.TemporaryDirectory(dir=FOLDERS) as partial:
        packages = Path(partial) / "packages"
        options = ["--quiet", "--disable-pip-version-check", "--no-deps", "--require-hashes", "--target", packages]
        run = subprocess.run(
            [sys.executable, "-m", "pip", "install", *options, "-r", lock], capture_output=True, text=True, check=False
        )
        if run.returncode:
            pytest.fail(f"pip could not install {lock.name}, which this test needs:\n{run.stderr}", pytrace=False)
        packages.rename(folder)
