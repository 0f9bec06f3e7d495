"""The tracker without the rest of luxloop: the packages that it needs."""

import subprocess
import sys
from importlib.metadata import packages_distributions

import pytest

NEEDED = {"numpy", "scipy", "numba", "llvmlite", "filterpy"}
"""The four libraries, and llvmlite for numba."""

ALL_MODULES = """
import pkgutil, importlib, luxloop.tracker
for module in pkgutil.walk_packages(luxloop.tracker.__path__, "luxloop.tracker."):
    importlib.import_module(module.name)
"""

MOTION = "from luxloop.tracker.tracking.filters import FilterConfig, motion; motion(0.08, FilterConfig())"
"""Loads filterpy, which the filters import when they are first used."""


@pytest.mark.parametrize("code", ["import luxloop.tracker.tracker", ALL_MODULES], ids=["tracker", "all modules"])
def test_the_tracker_imports_only_its_four_libraries(code):
    """No other installed package can be imported. Those that the libraries import if installed do not count."""
    others = {f"luxloop.{package}" for package in ("sim", "sensor_model", "scenarios")}
    absent = sorted({*packages_distributions(), *others} - NEEDED - {"luxloop"})
    block = f"import sys\nsys.modules.update(dict.fromkeys({absent}))\n"
    names = "print(*{name.partition('.')[0] for name, module in sys.modules.items() if module})"
    command = [sys.executable, "-c", f"{block}{code}\n{MOTION}\n{names}"]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    assert set(run.stdout.split()) >= NEEDED
