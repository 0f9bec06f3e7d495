"""The page on regression tests and the workflows: their options and commands exist, and markers select the suites."""

import os
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from support.few import few
from support.optional import need
from support.paths import ROOT

from luxloop.scenarios.cli import app
from luxloop.scenarios.files import shipped
from luxloop.scenarios.files.scenario import Scenario

PAGE, WORKFLOW = ROOT / "docs" / "regression-tests.md", ROOT / ".github" / "workflows" / "ci.yml"
TEXT = PAGE.read_text(encoding="utf-8")
(GIVEN,) = re.findall(r"^```yaml\n(.*?)^```", TEXT, flags=re.DOTALL | re.MULTILINE)
COMMANDS = {command.name or command.callback.__name__.replace("_", "-") for command in app.registered_commands}


def pytest_says(*arguments):
    environment = {**os.environ, "PYTEST_ADDOPTS": ""}
    command = [sys.executable, "-m", "pytest", *arguments]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def pytest_help():
    return pytest_says("--help")


def runs(workflow):
    """Return every command of a workflow."""
    return [shlex.split(line) for line in re.findall(r"run: (.+)$", workflow, flags=re.MULTILINE)]


@pytest.mark.parametrize("suite", few(["smoke", "full"], "smoke"))
def test_the_markers_select_the_suites(suite):
    out = pytest_says(str(shipped.CATALOG), "--collect-only", "-q", "-m", suite)
    loaded = [Scenario.load(path) for path in shipped.paths().values()]
    wanted = {scenario.name for scenario in loaded if suite in ("full", scenario.suite)}
    assert {Path(line.partition("::")[0]).stem for line in out.splitlines() if "::" in line} == wanted


def test_the_documented_options_are_those_of_the_plug_in(pytest_help):
    options = set(re.findall(r"--luxloop-[\w-]+", TEXT + WORKFLOW.read_text(encoding="utf-8")))
    assert options == set(re.findall(r"--luxloop-[\w-]+", pytest_help))
    assert {"smoke", "full"} <= set(re.findall(r"@pytest\.mark\.(\w+)", pytest_says("--markers")))


def test_the_workflow_on_the_page_is_that_of_the_example_repository():
    assert (ROOT / "docs" / "examples" / "ci" / ".github" / "workflows" / "tracker.yml").read_text("utf-8") == GIVEN
    assert [words[1] for words in runs(GIVEN) if words[0] == "luxloop"] == ["warm-up", "compare"]
    assert {"warm-up", "compare"} <= COMMANDS


def test_the_workflow_of_luxloop_runs_the_targets_of_the_ci_script_under_every_python():
    need("docs", "yaml")
    import yaml

    (job,) = yaml.safe_load(WORKFLOW.read_text(encoding="utf-8"))["jobs"].values()
    assert [step["run"] for step in job["steps"] if "run" in step] == ["make ${{ matrix.target }} PYTHON=python"]
    assert os.access(ROOT / ".ci" / "run", os.X_OK)
    targets = re.search(r"^\.PHONY: (.*)$", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)[1].split()
    typed = re.findall(r"^make (\w+)$", (ROOT / ".ci" / "run").read_text(encoding="utf-8"), re.MULTILINE)
    matrix = job["strategy"]["matrix"]
    assert typed == ["demo", *matrix["target"]] == ["demo", "check", "test", "slow", "catalog", "wheel"]
    assert set(typed) <= set(targets)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert [f"Programming Language :: Python :: {python}" for python in matrix["python"]] == [
        line for line in project["classifiers"] if re.search(r":: 3\.\d+$", line)
    ]
