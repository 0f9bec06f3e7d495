"""Help and completion: brackets are shown as written, names of scenarios are completed."""

import os
import subprocess
import sys

import pytest

from luxloop.scenarios.cli import main
from luxloop.scenarios.files import shipped


@pytest.mark.parametrize(
    ("command", "text"),
    [
        ("track", "Scenario whose [tracker], [grading] and [expect] are used."),
        ("compare", "Loss to exclude for an exit code of 0 [%]."),
        ("grade", "Scenario whose [grading] and [expect] replace the run's."),
        ("import", "instead of a rig file; one per LIDAR."),
    ],
)
def test_help_shows_brackets(command, text, capfd, monkeypatch):
    monkeypatch.setenv("TERMINAL_WIDTH", "200")
    monkeypatch.setenv("COLUMNS", "200")
    assert main([command, "--help"]) == 0
    assert text in " ".join(capfd.readouterr().out.replace("│", " ").split())


def complete(words):
    environment = os.environ | {
        "_LUXLOOP_COMPLETE": "complete_bash", "COMP_WORDS": words, "COMP_CWORD": str(len(words.split()) - 1),
    }  # fmt: skip
    command = [sys.executable, "-m", "luxloop"]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout.split()


def test_commands_options_and_names_are_completed():
    assert complete("luxloop comp") == ["compare"]
    assert "--seeds" in complete("luxloop run --se")
    assert sorted(complete("luxloop run truck")) == sorted(name for name in shipped.paths() if name.startswith("truck"))
    assert "occlusion" in complete("luxloop sweep occ")
