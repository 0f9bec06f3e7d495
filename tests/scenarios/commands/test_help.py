"""Help and completion: brackets are shown as written, names of scenarios are completed."""

import inspect
import os
import subprocess
import sys

import pytest

from luxloop.scenarios.cli import COMMANDS, app, main
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


def help_of(*command):
    environment = os.environ | {"COLUMNS": "80"}
    arguments = [sys.executable, "-m", "luxloop", *command, "--help"]
    return subprocess.run(arguments, env=environment, capture_output=True, text=True, check=True).stdout


def test_the_help_of_the_program_has_every_command_on_one_line_of_its_group():
    lines = help_of().splitlines()
    assert max(map(len, lines)) <= 80
    for group, commands in COMMANDS.items():
        start = lines.index(f"{group}:") + 1
        shown = [f"  {name:15}{line}" for name, (_, line) in commands.items()]
        assert lines[start : start + len(shown) + 1] == [*shown, ""]


@pytest.mark.parametrize("command", [name for commands in COMMANDS.values() for name in commands])
def test_the_help_of_a_command_fits_80_columns_and_breaks_no_word(command, capfd, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    assert main([command, "--help"]) == 0
    lines = capfd.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 80
    (program,) = (entry for entry in app.registered_commands if entry.name == command)
    summary = inspect.getdoc(program.callback).splitlines()[0]
    assert summary.split(".")[0] in " ".join(" ".join(lines).split())


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
