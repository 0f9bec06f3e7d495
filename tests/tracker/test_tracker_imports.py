"""The tracker without the rest of luxloop: the packages that it needs."""

import ast
import subprocess
import sys
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest
from support.few import few

ROOT = Path(__file__).parents[2]
NEEDED = {"numpy", "scipy", "numba", "llvmlite", "filterpy"}
"""The four libraries, and llvmlite for numba."""

ALL_MODULES = """
import pkgutil, importlib, luxloop.tracker
for module in pkgutil.walk_packages(luxloop.tracker.__path__, "luxloop.tracker."):
    importlib.import_module(module.name)
"""

FILTERPY = "from luxloop.tracker.tracking.model_selection import kalman_filter; kalman_filter()"
"""Loads filterpy, which only its own filters import, when they are first used."""


@pytest.mark.parametrize(
    "code", few(["import luxloop.tracker.tracker", ALL_MODULES], ALL_MODULES), ids=["tracker", "all modules"]
)
def test_the_tracker_imports_only_its_four_libraries(code):
    """No other installed package can be imported. Those that the libraries import if installed do not count."""
    others = {f"luxloop.{package}" for package in ("sim", "sensor_model", "scenarios")}
    absent = sorted({*packages_distributions(), *others} - NEEDED - {"luxloop"})
    block = f"import sys\nsys.modules.update(dict.fromkeys({absent}))\n"
    names = "print(*{name.partition('.')[0] for name, module in sys.modules.items() if module})"
    command = [sys.executable, "-c", f"{block}{code}\n{FILTERPY}\n{names}"]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    assert set(run.stdout.split()) >= NEEDED


USERS = sorted(path for name in ("oracle", "league") for path in (ROOT / "scenarios" / name).rglob("*.py"))
"""Modules that replace stages of the tracker."""


@pytest.mark.parametrize("path", USERS, ids=lambda path: path.stem)
def test_oracles_and_peers_use_the_documented_protocols_only(path):
    """As users must: no private module, name or attribute of the tracker."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("luxloop.tracker"):
            names = [*node.module.split("."), *(alias.name for alias in node.names)]
            assert not [name for name in names if name.startswith("_")]
        if isinstance(node, ast.Attribute) and node.attr.startswith("_") and not node.attr.startswith("__"):
            assert ast.unparse(node.value) in {"self", "cls", "os"}, ast.unparse(node)
