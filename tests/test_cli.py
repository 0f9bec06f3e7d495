"""The command line: exit codes, one line for every mistake, nothing left behind, the same trace everywhere."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from support import short_run

from scenarios import listing
from scenarios.cli import main
from sim.scripted import ScriptedSource
from sim.source import TrafficEndedError

CROSSING = listing.CATALOG / "urban" / "sumo-crossing"
SUMO = f"""\
description = "For mistakes."
duration_s = 1
[traffic]
kind = "sumo"
net = "{CROSSING / "crossing.net.xml"}"
routes = ["ego.rou.xml"]
ego = "vehicle:ego"
"""
EGO = '<vehicle id="ego" depart="0" departSpeed="10"><route edges="south_in north_out"/></vehicle>'
HIGHWAY = 'description = "x"\nduration_s = 1\n[traffic]\nkind = "highway-env"\nenv = "highway-v0"\n'


@pytest.fixture(autouse=True)
def _in_an_own_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)


def tree(folder="."):
    return sorted(str(path) for path in Path(folder).rglob("*") if "__pycache__" not in path.parts)


@pytest.mark.parametrize(
    ("files", "arguments", "code", "complaint"),
    [
        ({}, ["missing.toml"], 2, "missing.toml: No such file or directory; give a readable file or a name"),
        ({}, ["rng"], 2, "rng: no such scenario; did you mean ring"),
        ({"a.toml": "sead = 1\n" + SUMO}, ["a.toml"], 2, "a.toml: sead = 1: unknown key; did you mean seed?"),
        ({"a.toml": SUMO.replace("= 1", '= "1"')}, ["a.toml"], 2, 'a.toml: duration_s = "1": should be a valid number'),
        ({"a.toml": SUMO.replace("= 1", "= -1")}, ["a.toml"], 2, "a.toml: duration_s = -1: should be greater than 0"),
        ({"a.toml": SUMO}, ["a.toml", "--duration", "-2"], 2, "a.toml: duration_s = -2.0: should be greater than 0"),
        ({"a.toml": SUMO}, ["a.toml"], 2, "ego.rou.xml: no such file"),
        (
            {"a.toml": SUMO.replace(":ego", ":nobody"), "ego.rou.xml": f"<routes>{EGO}</routes>"},
            ["a.toml"],
            2,
            'a.toml: traffic: ego = "vehicle:nobody" did not enter',
        ),
        (
            {
                "a.toml": SUMO.replace(str(CROSSING / "crossing.net.xml"), "net.xml"),
                "net.xml": "<net",
                "ego.rou.xml": "",
            },
            ["a.toml"],
            2,
            "net.xml",
        ),
        (
            {"a.toml": HIGHWAY.replace("highway-v0", "hihgway-v0")},
            ["a.toml"],
            2,
            'a.toml: traffic: env = "hihgway-v0" is',
        ),
        (
            {"a.toml": short_run.TEXT + "[rig]\nfile = 'r.toml'", "r.toml": "rear_axle_x_m = -1\nunit = []"},
            ["a.toml"],
            2,
            "r.toml: unit = []: give at least one [[unit]] table",
        ),
        ({"a.toml": short_run.TEXT + "[rig]\nname = 'r'"}, ["a.toml"], 2, "no such rig file"),
        ({"a.toml": short_run.TEXT, "f": ""}, ["a.toml", "--out", "f/run"], 2, "f/run: cannot write there"),
        ({"a.toml": short_run.TEXT, "f": ""}, ["a.toml", "--out", "f"], 2, "f: is a file"),
        ({"a.toml": short_run.TEXT}, ["a.toml", "--out", "."], 2, "holds other things than a run"),
        ({"a.toml": short_run.TEXT}, ["a.toml", "--out", "n" * 300], 2, "cannot write there (File name too long)"),
        ({"a.toml": short_run.TEXT}, ["a.toml", "--tracker", "mine:Tracker"], 2, "no module mine on the Python path"),
        ({"a.toml": short_run.TEXT}, ["a.toml", "--seed", "one"], 2, "Invalid value for '--seed'"),
        ({"a.toml": short_run.TEXT}, ["a.toml", "--sead", "1"], 2, "No such option"),
        (
            {
                "a.toml": SUMO + 'options = { route-steps = "1" }',
                "ego.rou.xml": f"<routes>{EGO}"
                '<vehicle id="late" depart="2"><route edges="south_in north_out"/></vehicle>'
                '<vehicle id="lost" depart="9"><route edges="nowhere"/></vehicle></routes>',
            },
            ["a.toml", "--duration", "5"],
            3,
            "nowhere",
        ),
    ],
)
def test_a_mistake_is_one_line_on_standard_error_and_leaves_nothing(files, arguments, code, complaint, capfd):
    for name, text in files.items():
        Path(name).write_text(text, encoding="utf-8")
    before = tree()
    assert main(["run", *arguments]) == code
    out, err = capfd.readouterr()
    assert out == ""
    assert err.startswith("luxloop: error: ")
    assert err.count("\n") == 1
    assert complaint in err
    assert tree() == before


def test_an_output_folder_that_cannot_be_written_is_found_out_before_simulating(capfd):
    """The traffic is wrong as well; the complaint is about what comes first."""
    Path("a.toml").write_text(SUMO.replace("vehicle:ego", "vehicle:nobody"))
    Path("file").write_text("")
    assert main(["run", "a.toml", "--out", "file/run"]) == 2
    assert "file/run: cannot write there" in capfd.readouterr().err


def test_a_run_prints_its_report_and_leaves_a_whole_folder(capfd):
    short_run.write(Path())
    assert main(["run", "short.toml", "--seed", "9"]) == 0
    out, err = capfd.readouterr()
    assert "Heading error by method" in out
    assert "PASSED" in out
    assert err == ""
    assert sorted(path.name for path in Path("runs/short-seed9").iterdir()) == [
        "recording.rrd", "report.txt", "result.json", "tables",
    ]  # fmt: skip
    assert Path("runs/short-seed9/report.txt").read_text() in out + "\n"


def test_json_is_the_result_and_nothing_else(capfd):
    short_run.write(Path())
    assert main(["run", "short.toml", "--json", "--no-recording", "--out", "here"]) == 0
    out, err = capfd.readouterr()
    document = json.loads(out)
    assert err == ""
    assert document["scenario"] == "short"
    assert document["seed"] == 4
    assert document["verdict"] == "passed"
    assert document["failed"] == []
    assert document["complete"] is True
    assert document["out"] == "here"
    assert document["trace_hash"] == short_run.result().trace_hash
    assert document["metrics"]["mma.switch_latency_frames"]["value"] is None
    assert document["metrics"]["mma.switch_latency_frames"]["reason"]
    assert not Path("here/recording.rrd").exists()


@pytest.mark.parametrize("limit", ["{min = 1.01}", "{max = -0.01}"])
def test_a_failed_expectation_exits_with_1_and_keeps_the_run(limit, capfd):
    short_run.write(Path(), short_run.TEXT + f'[expect]\n"track.idf1" = {limit}\n"track.mota" = {{max = 1}}')
    assert main(["run", "short.toml", "--json", "--no-recording"]) == 1
    document = json.loads(capfd.readouterr().out)
    assert document["verdict"] == "failed"
    assert document["failed"] == ["track.idf1"]
    assert json.loads(Path("runs/short-seed4/result.json").read_text())["verdict"] == "failed"


def test_an_expectation_on_what_does_not_apply_fails(capfd):
    short_run.write(Path(), short_run.TEXT + '[expect]\n"mma.switch_latency_frames" = {max = 1000}')
    assert main(["run", "short.toml", "--no-recording"]) == 1
    assert "FAILED: 0 of 1 expectations hold" in capfd.readouterr().out


class Over(ScriptedSource):
    """The ego is gone before it is seen: a promise of `TrafficSource` that no source of ours happens to use."""

    def step(self):
        raise TrafficEndedError("the ego left at 0.00 s")


def test_traffic_that_ends_before_its_first_frame_is_bad_input(monkeypatch, capfd):
    monkeypatch.setattr("scenarios.loop.ScriptedSource", Over)
    short_run.write(Path())
    before = tree()
    assert main(["run", "short.toml"]) == 2
    assert capfd.readouterr() == ("", "luxloop: error: the ego left at 0.00 s\n")
    assert tree() == before


INTERRUPTED = """
class Tracker:
    def __init__(self, config):
        pass
    def step(self, scan):
        raise KeyboardInterrupt
"""


def test_ctrl_c_leaves_nothing_but_a_line(capfd):
    short_run.write(Path())
    Path("impatient.py").write_text(INTERRUPTED)
    before = tree()
    assert main(["run", "short.toml", "--tracker", "impatient:Tracker"]) == 130
    assert capfd.readouterr().err == "luxloop: error: interrupted; nothing was written\n"
    assert tree() == before


def test_an_error_of_our_own_keeps_its_traceback():
    short_run.write(Path())
    Path("broken.py").write_text(INTERRUPTED.replace("KeyboardInterrupt", "ZeroDivisionError"))
    before = tree()
    with pytest.raises(ZeroDivisionError):
        main(["run", "short.toml", "--tracker", "broken:Tracker"])
    assert tree() == before


def test_view_wants_a_run_with_a_recording(capfd):
    assert main(["view", "nowhere"]) == 2
    assert "no result.json of a run in it" in capfd.readouterr().err


def test_list_tells_every_scenario_with_its_family(capfd):
    assert main(["list"]) == 0
    out = capfd.readouterr().out
    for entry in listing.entries():
        assert entry.name in out
        assert entry.family in out


def test_without_arguments_it_helps(capfd, monkeypatch):
    monkeypatch.setattr("sys.argv", ["luxloop"])
    assert main() == 0
    assert "Usage: luxloop" in capfd.readouterr().out


def luxloop(*arguments, **environment):
    """The real command, in a process of its own."""
    command = [str(Path(sys.executable).with_name("luxloop")), *arguments]
    return subprocess.run(command, env={**os.environ, **environment}, capture_output=True, text=True, check=False)


def test_help_and_list_are_quick_because_they_import_nothing_heavy():
    code = "import sys; from scenarios.cli import main; main(['list']); print(*sys.modules)"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    heavy = {"numpy", "pandas", "numba", "libsumo", "highway_env", "rerun", "trackeval"}
    assert heavy.isdisjoint(out.splitlines()[-1].split())


def test_the_trace_is_the_same_in_any_process_under_any_hash_seed(capfd):
    """SUMO hands out its vehicles in dicts and sets keyed by their names."""
    arguments = ("run", "sumo-crossing", "--duration", "1", "--no-recording", "--json")
    runs = [luxloop(*arguments, PYTHONHASHSEED=seed) for seed in ("1", "2")]
    assert main(list(arguments)) in (0, 1)
    documents = [json.loads(run.stdout) for run in runs] + [json.loads(capfd.readouterr().out)]
    assert [run.stderr for run in runs] == ["", ""]
    assert len({document["trace_hash"] for document in documents}) == 1
    assert main([*arguments, "--seed", "2"]) in (0, 1)
    assert json.loads(capfd.readouterr().out)["trace_hash"] != documents[0]["trace_hash"]


def test_the_real_command_hands_on_its_exit_code():
    run = luxloop("run", "missing.toml")
    assert (run.returncode, run.stdout) == (2, "")
    assert run.stderr.startswith("luxloop: error: missing.toml")
