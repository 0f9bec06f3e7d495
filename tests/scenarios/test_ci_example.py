"""The example repository: its files are valid, and the commands of its workflow run in this order."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from support.optional import need

need("docs", "yaml")

import yaml
from support.paths import DOCS, EXAMPLES

from luxloop.scenarios.files.scenario import Scenario

REPOSITORY = EXAMPLES / "ci"
CACHES = shutil.ignore_patterns("__pycache__", ".pytest_cache")


@pytest.fixture(scope="module")
def steps():
    workflow = yaml.safe_load((REPOSITORY / ".github" / "workflows" / "tracker.yml").read_text(encoding="utf-8"))
    return workflow["jobs"]["cases"]["steps"]


@pytest.fixture
def clone(tmp_path):
    """A copy of the repository, without the caches of editors and interpreters."""
    shutil.copytree(REPOSITORY, tmp_path / "clone", ignore=CACHES)
    return tmp_path / "clone"


def shell(line, folder, **settings):
    """Run a command of the workflow with the commands of this environment, and further environment variables."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST_", "GITHUB_"))}
    environment["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    environment["GITHUB_STEP_SUMMARY"] = str(folder / "summary.md")
    environment |= settings
    done = subprocess.run(
        ["bash", "-ec", line], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    return done.returncode, done.stdout + done.stderr


def commands(steps, *programs):
    return [step["run"] for step in steps if step.get("run", "").split()[:1] and step["run"].split()[0] in programs]


def test_every_case_is_a_valid_scenario_with_needs():
    cases = sorted((REPOSITORY / "cases").glob("*.toml"))
    assert len(cases) >= 2
    for case in cases:
        scenario = Scenario.load(case)
        assert scenario.expect
        assert all(limit.need for limit in scenario.expect.values())


def test_the_commands_of_the_page_make_a_repository_of_the_tracker(tmp_path):
    """Fails if the address of luxloop is not put in, or a file of the example is ignored by git."""
    page = (DOCS / "own-tracker.md").read_text(encoding="utf-8")
    first, then = re.findall(r"^```console\n(.*?)^```", page, re.MULTILINE | re.DOTALL)[:2]
    assert (len(first.splitlines()), len(then.splitlines())) == (5, 3)
    (copied,) = [line for line in first.splitlines() if line.startswith("cp ")]
    shutil.copytree(REPOSITORY, tmp_path / "luxloop" / "docs" / "examples" / "ci", ignore=CACHES)
    commit = "git -c user.name=a -c user.email=a@b commit"
    made = (
        "git init -qb main luxloop && cd luxloop && git add . && "
        + commit
        + " -qm a && cd .. && git init -q --bare theirs"
    )
    typed = (
        then.replace("git commit", commit).replace("ADDRESS", "https://a.example/b").replace("REPOSITORY", "../theirs")
    )
    code, said = shell(f"{made}\n{copied}\n{typed}", tmp_path)
    assert code == 0, said
    assert re.search(
        r"^git\+https://a\.example/b@[0-9a-f]{40}$", (tmp_path / "mine" / "requirements.txt").read_text(), re.M
    )
    _, pushed = shell("git -C theirs ls-tree -r --name-only main", tmp_path)
    files = (path.relative_to(REPOSITORY) for path in REPOSITORY.rglob("*") if path.is_file())
    assert {name for name in pushed.split() if "__pycache__" not in name} == {
        str(path) for path in files if not {"__pycache__", ".pytest_cache"} & set(path.parts)
    }


def test_the_cache_has_kernels_and_packages_in_one_entry(steps):
    (cache,) = [step["with"] for step in steps if step.get("uses", "").startswith("actions/cache@")]
    assert cache["path"].split() == [".venv", ".numba"]
    assert "hashFiles('pyproject.toml', 'requirements.txt')" in cache["key"]


@pytest.mark.slow
def test_commands_of_the_workflow_run_and_the_second_push_is_the_same(steps, clone):
    warm_up, tests, compare, summary = commands(steps, "luxloop", "pytest", "cat")
    assert shell(warm_up, clone)[0] == 0
    code, said = shell(tests, clone)
    assert code == 0, said
    assert "6 passed" in said
    assert "The report is in luxloop.html" in said
    assert shell("luxloop baseline runs --out baseline.jsonl", clone)[0] == 0
    code, said = shell(compare, clone)
    assert code == 0, said
    assert shell(summary, clone)[0] == 0
    assert (clone / "summary.md").read_text(encoding="utf-8").startswith("### Comparison of two versions: same")


def kernels_in(cache):
    return {path: path.stat().st_mtime_ns for path in cache.rglob("*.nbc")}


@pytest.mark.slow
def test_the_warm_up_compiles_every_kernel_so_that_no_run_does(steps, clone):
    """Two workers would otherwise compile the same kernels at once, and the two processes of a run for other types."""
    warm_up, tests, *_ = commands(steps, "luxloop", "pytest", "cat")
    run = "luxloop run sumo-crossing --duration 0.8 --no-recording --out crossing || test $? = 1"
    cache, kernels = clone / ".numba", {}
    for compiling, running in ((warm_up, tests), ("luxloop warm-up", run)):
        assert shell(compiling, clone, NUMBA_CACHE_DIR=str(cache))[0] == 0
        before, kernels = kernels, kernels_in(cache)
        assert len(kernels) > len(before)
        code, said = shell(running, clone, NUMBA_CACHE_DIR=str(cache))
        assert code == 0, said
        assert kernels_in(cache) == kernels


@pytest.mark.slow
def test_folders_of_failed_runs_are_kept(steps, clone):
    case = clone / "cases" / "braking-ahead.toml"
    case.write_text(case.read_text(encoding="utf-8").replace("max = 30", "max = -1"), encoding="utf-8")
    assert shell("pytest -n 0", clone)[0] == 1
    (keep,) = [step["run"] for step in steps if step.get("if") == "failure()"]
    assert shell(keep, clone)[0] == 0
    kept = [json.loads(path.read_text(encoding="utf-8")) for path in (clone / "failed").rglob("result.json")]
    assert [(run["scenario"], run["verdict"]) for run in kept] == [("braking-ahead", "failed")]
