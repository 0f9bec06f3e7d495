"""The example repository installs luxloop from a pinned revision of a bare clone, without network."""

import re
import shutil
import subprocess

import pytest
from support.installed import INSTALLED, copy_kernels, run_checked
from support.paths import EXAMPLES, ROOT

PINNED = re.compile(r"^git\+https://git\.example\.com/luxloop\.git@[0-9a-f]{40}$", re.MULTILINE)
STEPS = r"^      - run: (test -d .*|luxloop warm-up .*|pytest .*)$"


@pytest.fixture
def address(tmp_path):
    """The address of a bare clone of this checkout, with its revision."""
    clone = tmp_path / "luxloop.git"
    done = subprocess.run(["git", "clone", "--quiet", "--bare", str(ROOT), str(clone)], check=False)
    if done.returncode:
        pytest.skip("not a git checkout")
    revision = subprocess.run(
        ["git", "rev-parse", "HEAD"], cwd=clone, capture_output=True, text=True, check=True
    ).stdout.strip()
    return f"git+{clone.as_uri()}@{revision}"


@pytest.mark.slow
def test_the_workflow_installs_the_pinned_revision_and_runs_the_cases(address, tmp_path):
    """Only the address differs from the example; pip finds the other packages in this environment."""
    repository = tmp_path / "repository"
    shutil.copytree(EXAMPLES / "ci", repository, ignore=shutil.ignore_patterns("__pycache__"))
    requirements = repository / "requirements.txt"
    pinned, count = PINNED.subn(address, requirements.read_text(encoding="utf-8"))
    assert count == 1
    requirements.write_text(pinned, encoding="utf-8")
    workflow = (repository / ".github" / "workflows" / "tracker.yml").read_text(encoding="utf-8")
    install, warm_up, tests = re.findall(STEPS, workflow, re.MULTILINE)
    settings = {"PYTHONPATH": INSTALLED, "PIP_NO_BUILD_ISOLATION": "0"}
    run_checked(["bash", "-ec", install], repository, **settings)
    (here,) = repository.glob(".venv/lib/python*/site-packages")
    assert (here / "luxloop" / "sim" / "world.py").is_file()
    copy_kernels(here)
    python = repository / ".venv" / "bin" / "python"
    program = python.with_name("pytest")  # pip made none: it found the package in this environment
    program.write_text(f'#!/bin/sh\nexec "{python}" -m pytest "$@"\n', encoding="utf-8")
    program.chmod(0o755)
    path = 'export PATH="$PWD/.venv/bin:$PATH"; '
    run_checked(["bash", "-ec", path + warm_up], repository, **settings)
    assert "6 passed" in run_checked(["bash", "-ec", path + tests], repository, **settings)
