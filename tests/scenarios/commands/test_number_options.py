"""Numbers on the command line: each is finite and in its range, or is refused before anything is simulated."""

from typing import get_type_hints

import pytest
from support.few import few

from luxloop.scenarios.cli import app, main


def number_options():
    """Yield a command and an option for each option that takes a number."""
    for command in app.registered_commands:
        for name, hint in get_type_hints(command.callback).items():
            if hint in (float, float | None):
                yield command.name or command.callback.__name__.strip("_"), f"--{name.replace('_', '-')}"


OPTIONS = sorted(number_options())


@pytest.mark.parametrize(("command", "option"), OPTIONS, ids=" ".join)
@pytest.mark.parametrize("value", few(["inf", "-inf", "nan"], "inf", "nan"))
def test_a_number_that_is_not_finite_is_refused_by_its_option(capfd, command, option, value):
    assert main([command, option, value]) == 2
    (line,) = capfd.readouterr().err.splitlines()
    assert line.startswith(f"luxloop: error: Invalid value for '{option}': ")


@pytest.mark.parametrize("option", ["--begin", "--window", "--stay"])
def test_an_infinite_number_is_named_as_such(capfd, option):
    assert main(["egos", "sumo-crossing", option, "inf"]) == 2
    assert f"Invalid value for '{option}': inf: should be a finite number" in capfd.readouterr().err


def test_numbers_of_all_commands_are_found():
    assert {("egos", "--begin"), ("new", "--window"), ("league", "--duration"), ("run", "--duration")} <= set(OPTIONS)


@pytest.mark.parametrize("command", [["egos", "sumo-crossing"], ["new", "sumo-crossing", "--out", "new.toml"]])
@pytest.mark.parametrize("option", ["--begin", "--seed"])
def test_a_negative_number_is_refused_by_its_option(capfd, tmp_path, monkeypatch, command, option):
    monkeypatch.chdir(tmp_path)
    assert main([*command, option, "-5"]) == 2
    assert f"Invalid value for '{option}': Input should be greater than or equal to 0" in capfd.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_cut_off_of_gospa_that_is_too_large_is_told_its_range(capfd):
    assert main(["grade", "--truth", "a.csv", "--tracks", "b.csv", "--gospa-cutoff", "2e6"]) == 2
    assert "--gospa-cutoff 2e+06: should be more than 0 and less than 1e6" in capfd.readouterr().err


def test_a_folder_in_place_of_the_new_file_is_refused_before_the_traffic_is_read(capfd, tmp_path):
    folder = tmp_path / "folder.toml"
    folder.mkdir()
    assert main(["new", "nowhere", "--out", str(folder), "--force"]) == 2
    assert f"--out {folder}: is a folder; name the file to write" in capfd.readouterr().err
