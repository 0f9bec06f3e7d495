"""Import contracts: a wrong import in a module that is added later breaks them."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("sim", "sensor_model", "tracker", "scenarios")

WRONG = {
    "tracker/detection/new.py": ("import luxloop.tracker.tracking.track", "detection and tracking are independent"),
    "tracker/new_module.py": ("import luxloop.sensor_model.lidar", "sim and tracker, which are independent"),
    "sim/highway/new.py": ("import libsumo", "Only luxloop.sim.sumo imports libsumo"),
    "sensor_model/noise/new.py": (
        "import luxloop.sim.sumo.sumo_source",
        "The sensor imports nothing that makes traffic",
    ),
    "scenarios/grading/new.py": ("import rerun", "Only luxloop.scenarios.rerun_log imports rerun"),
    "scenarios/grading/newer.py": (
        "import luxloop.scenarios.exchange.kitti.kitti_labels",
        "Plug-ins are imported by entry points only",
    ),
    "scenarios/files/new.py": ("import luxloop.scenarios.report.text", "Layers inside scenarios"),
    "scenarios/new_folder/__init__.py": ("", "Layers inside scenarios"),
}
"""New modules with their text, and the contract that each of them breaks."""


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """Output of `lint-imports` on a copy of the packages with the new modules, without line breaks."""
    folder = tmp_path_factory.mktemp("copy")
    for package in PACKAGES:
        shutil.copytree(ROOT / package, folder / package, ignore=shutil.ignore_patterns("__pycache__", "catalog"))
    shutil.copytree(ROOT / "luxloop", folder / "luxloop", symlinks=True)
    shutil.copy(ROOT / "pyproject.toml", folder)
    for module, (text, _) in WRONG.items():
        (folder / module).parent.mkdir(exist_ok=True)
        (folder / module).write_text(text + "\n", encoding="utf-8")
    command = [str(Path(sys.executable).with_name("lint-imports")), "--no-cache"]
    environment = {**os.environ, "PYTHONPATH": str(folder)}
    run = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert run.returncode == 1, run.stderr
    return " ".join(run.stdout.split())


@pytest.mark.parametrize("module", WRONG)
def test_a_wrong_import_in_a_new_module_breaks_its_contract(report, module):
    contract = WRONG[module][1]
    kept_or_broken, _, details = report.partition("Broken contracts")
    assert re.search(rf"{contract}[^:]*? BROKEN", kept_or_broken)
    name = module.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
    assert re.search(rf"\b{re.escape(name)}\b", details)
