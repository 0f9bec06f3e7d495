"""The tracker without the rest of luxloop: the packages that it imports."""

import subprocess
import sys
from importlib.metadata import packages_distributions

import pytest

LIBRARIES = {"numpy", "scipy", "numba", "filterpy"}
OF_NUMBA = {"llvmlite", "yaml"}
"""numba imports these itself, PyYAML only if it is installed."""

MODULES = """
import pkgutil, importlib, sys
import tracker
for module in pkgutil.walk_packages(tracker.__path__, "tracker."):
    importlib.import_module(module.name)
"""


@pytest.mark.parametrize("code", ["import tracker.tracker", MODULES], ids=["tracker", "all modules"])
def test_the_tracker_imports_only_its_four_libraries(code):
    command = [sys.executable, "-c", f"import sys\n{code}\nprint(*{{name.split('.')[0] for name in sys.modules}})"]
    printed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    installed = set(printed.split()) & set(packages_distributions()) - {"tracker", "_distutils_hack", "google"}
    assert installed - OF_NUMBA == LIBRARIES
