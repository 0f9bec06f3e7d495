"""Kernels in numba's cache do not outlive a change of a kernel or a constant in another file that they use."""

import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

CALLEE = """
from toy.compiled import kernel
from toy.limits import LIMIT

@kernel()
def callee():
    return {value} + LIMIT
"""
CALLER = """
from toy.compiled import kernel
from toy.kernels import middle

@kernel()
def caller(x):
    return x * middle.passed_on()
"""
MIDDLE = """
from toy.compiled import kernel
from toy.kernels.callee import callee

@kernel()
def passed_on():
    return callee()
"""
PROGRAM = "from toy.kernels.caller import caller; print(caller(10), sum(caller.stats.cache_hits.values()))"


@pytest.fixture
def toy(tmp_path):
    """Path of a package `toy` with luxloop's decorator, in which `caller(10)` is 30."""
    folder = tmp_path / "toy"
    (folder / "kernels").mkdir(parents=True)
    for path in (folder / "__init__.py", folder / "kernels/__init__.py"):
        path.touch()
    shutil.copy(ROOT / "luxloop" / "compiled.py", folder)
    (folder / "limits.py").write_text("LIMIT = 1\n")
    (folder / "kernels/callee.py").write_text(CALLEE.format(value=2))
    (folder / "kernels/middle.py").write_text(MIDDLE)
    (folder / "kernels/caller.py").write_text(CALLER)
    return folder


def result_of(toy, **environment):
    """Return the result of `caller(10)` in a new process, and True if it was in the cache."""
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], cwd=toy.parent, capture_output=True, text=True, check=True,
        env={**os.environ, "PYTHONPATH": str(toy.parent), "PYTHONDONTWRITEBYTECODE": "1"} | environment,
    )  # fmt: skip
    value, hits = done.stdout.split()
    return int(value), hits == "1"


def test_a_change_in_another_file_changes_the_stamp_of_its_callers(toy):
    """Without compiling: `kernel` gives this stamp to numba."""
    spec = importlib.util.spec_from_file_location("toy.compiled", toy / "compiled.py")
    compiled = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(compiled)
    caller, stamps = str(toy / "kernels/caller.py"), []
    for name, text in (
        ("unrelated.py", "X = 1\n"),
        ("kernels/callee.py", CALLEE.format(value=4)),
        ("limits.py", "LIMIT = 2\n"),
        ("unrelated.py", "X = 2\n"),
    ):
        (toy / name).write_text(text)
        for cached in (compiled._stamp, compiled._sources, compiled._path, compiled._text):
            cached.cache_clear()
        stamps.append(compiled._stamp(caller))
    assert len({*stamps}) == 3
    assert stamps[2] == stamps[3]


@pytest.mark.slow
def test_a_change_in_another_file_compiles_the_callers_again(toy):
    assert result_of(toy) == (30, False)
    assert result_of(toy) == (30, True)
    (toy / "kernels/callee.py").write_text(CALLEE.format(value=4))
    assert result_of(toy) == (50, False)
    assert result_of(toy) == (50, True)
    (toy / "limits.py").write_text("LIMIT = 2\n")
    assert result_of(toy) == (60, False)
    (toy / "unrelated.py").write_text("X = 1\n")
    assert result_of(toy) == (60, True)


@pytest.mark.slow
def test_it_holds_in_another_cache_folder_too(toy, tmp_path):
    other = {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    assert result_of(toy, **other) == (30, False)
    (toy / "kernels/callee.py").write_text(CALLEE.format(value=4))
    assert result_of(toy, **other) == (50, False)
    assert result_of(toy, **other) == (50, True)
    assert not list(toy.rglob("*.nbi"))
