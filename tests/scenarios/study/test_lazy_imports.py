"""Optional packages are imported only when runs start."""

import subprocess
import sys

import pytest
from support.few import few
from support.optional import need

OPTIONAL = {"dask", "distributed", "fsspec", "optuna", "mcap", "mcap_ros2"}


MODULES = (
    "luxloop.scenarios.cli",
    "luxloop.scenarios.study.study_file",
    "luxloop.scenarios.study.study_page",
    "luxloop.scenarios.study.sweep_runs",
    "luxloop.scenarios.search.adversary",
)


@pytest.mark.parametrize("module", few(MODULES, "luxloop.scenarios.cli"))
def test_importing_a_module_loads_no_optional_package(module):
    if "search" in module:
        need("search")  # tomli_w, which is small, is imported with the module
    code = f"import sys, {module}; print(sorted({OPTIONAL!r} & sys.modules.keys()))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
