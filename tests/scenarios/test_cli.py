"""The command line: exit codes, one line for every mistake, nothing left behind, the same trace everywhere."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import pytest
from support import short_run

from scenarios.cli import main
from scenarios.files import shipped
from scenarios.run import run_folder
from sim.scripted.scripted_source import ScriptedSource
from sim.source import SimulatorFailedError, TrafficEndedError

CROSSING = shipped.CATALOG / "urban" / "sumo-crossing"
SUMO = f"""\
description = "For mistakes."
duration_s = 1
[traffic]
kind = "sumo"
net = "{CROSSING / "crossing.net.xml"}"
routes = ["ego.rou.xml"]
ego = "vehicle:ego"
"""
LOST = '<vehicle id="lost" depart="30"><route edges="nowhere"/></vehicle>'
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
        ({"a.toml": short_run.TEXT}, ["a.toml", "--out", "."], 2, "holds other files than those of a run"),
        ({"a.toml": short_run.TEXT}, ["a.toml", "--out", "n" * 300], 2, "cannot write there (File name too long)"),
        ({"a.toml": short_run.TEXT}, ["a.toml", "--tracker", "mine:Tracker"], 2, "no module mine on the Python path"),
        ({"a.toml": short_run.TEXT}, ["a.toml", "--seed", "one"], 2, "Invalid value for '--seed'"),
        ({"a.toml": short_run.TEXT}, ["a.toml", "--sead", "1"], 2, "No such option"),
        ({"a.toml": SUMO, "ego.rou.xml": f"<routes>{EGO}{LOST}</routes>"}, ["a.toml"], 2, "edge 'nowhere'"),
        ({"a.toml": SUMO.replace("vehicle:ego", "ego")}, ["a.toml"], 2, 'ego = "ego": write "vehicle:<id>", "route:'),
        ({"a.toml": SUMO + "dt_s = 0"}, ["a.toml"], 2, "a.toml: traffic: dt_s, max_wait_s and building_height_m must"),
        ({"a.toml": SUMO + "parking_fill = 1.5"}, ["a.toml"], 2, "a.toml: traffic: parking_fill = 1.5: write a share"),
        (
            {
                "a.toml": SUMO + 'options = { extrapolate-departpos = "maybe" }',
                "ego.rou.xml": f"<routes>{EGO}</routes>",
            },
            ["a.toml"],
            2,
            "a.toml: traffic: ",
        ),
        (
            {"a.toml": SUMO + 'options = { scale = "-1" }', "ego.rou.xml": f"<routes>{EGO}</routes>"},
            ["a.toml"],
            2,
            "a.toml: traffic: ",
        ),
        ({"a.toml": short_run.TEXT + "[noise.rain]\nrate_mm_per_h = -1"}, ["a.toml"], 2, "a.toml: noise.rain"),
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


def break_at(frame, error, monkeypatch):
    """Let scripted traffic come to an end before its frame of this number."""

    class Breaking(ScriptedSource):
        played = 0

        def step(self):
            if self.played == frame:
                raise error
            self.played += 1
            return super().step()

    monkeypatch.setattr("sim.factory.ScriptedSource", Breaking)


ENDS = pytest.mark.parametrize(
    ("error", "code"), [(TrafficEndedError("the ego left"), 1), (SimulatorFailedError("it gave\n  up."), 3)]
)


@ENDS
def test_without_a_single_frame_there_is_nothing_to_keep(error, code, monkeypatch, capfd):
    """An ego that is gone before it is seen is a mistake in the scenario."""
    break_at(0, error, monkeypatch)
    short_run.write(Path())
    before = tree()
    assert main(["run", "short.toml"]) == {1: 2, 3: 3}[code]
    assert capfd.readouterr() == ("", f"luxloop: error: {' '.join(str(error).split())}\n")
    assert tree() == before


@ENDS
def test_a_run_that_breaks_off_keeps_what_it_has_and_has_not_passed(error, code, monkeypatch, capfd):
    """All that it was to show holds over the frames that there are; those that are missing might be the hard ones."""
    break_at(4, error, monkeypatch)
    short_run.write(Path(), short_run.TEXT + '[expect]\n"track.mota" = {max = 1}')
    assert main(["run", "short.toml", "--json", "--out", "here"]) == code
    out, err = capfd.readouterr()
    assert_kept(Path("here"), json.loads(out), frames=4)
    assert set(run_folder.read(Path("here")).tables["truth"]["frame"]) == set(range(4))
    assert json.loads(out)["simulator_failed"] is (code == 3)
    said = " ".join(str(error).split()).removesuffix(".")
    assert err.startswith(f"luxloop: error: {said}; ")
    assert err.endswith("; the 4 frames until then are in here, marked incomplete\n")
    assert err.count("\n") == 1


def assert_kept(folder, document, frames):
    """An incomplete run of so many frames: result, report, tables and recording say the same."""
    assert document["verdict"] == "incomplete"  # whatever its expectations say of the part that was run
    assert document["complete"] is False
    assert document["ended_early"]
    assert document["frames"] == frames > 0
    written = json.loads((folder / "result.json").read_text())
    assert written == {key: value for key, value in document.items() if key != "out"}
    assert "INCOMPLETE" in (folder / "report.txt").read_text()
    assert (run_folder.read(folder).tables["truth"]["frame"] < frames).all()
    rerun = [sys.executable, "-m", "rerun", "rrd", "verify", str(run_folder.recording(folder))]
    assert subprocess.run(rerun, capture_output=True, check=False).returncode == 0


def test_a_report_of_an_incomplete_run_is_printed_and_the_line_comes_beside_it(monkeypatch, capfd):
    break_at(4, TrafficEndedError("the ego left"), monkeypatch)
    short_run.write(Path())
    assert main(["run", "short.toml", "--no-recording"]) == 1
    out, err = capfd.readouterr()
    assert "INCOMPLETE: 0 of 0 expectations hold so far; it ended early: the ego left" in out
    assert "Results are in runs/short-seed4" in out
    assert err == (
        "luxloop: error: the ego left; give the ego a longer way, or the run a shorter --duration; "
        "the 4 frames until then are in runs/short-seed4, marked incomplete\n"
    )


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


def test_ctrl_c_that_numba_turns_into_another_error_is_still_one(capfd):
    """It comes so when a kernel is just being loaded."""
    interrupted = INTERRUPTED.replace("raise KeyboardInterrupt", "raise SystemError from KeyboardInterrupt()")
    short_run.write(Path())
    Path("loading.py").write_text(interrupted)
    assert main(["run", "short.toml", "--tracker", "loading:Tracker"]) == 130
    assert capfd.readouterr().err == "luxloop: error: interrupted; nothing was written\n"


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
    for entry in shipped.entries():
        assert entry.name in out
        assert entry.family in out


def test_list_tells_every_study_with_its_command(capfd):
    assert main(["list", "--studies"]) == 0
    out = capfd.readouterr().out
    for command, study in (("sweep", "occlusion"), ("search", "lost-behind-wall")):
        assert re.search(rf"^{command} +{study} ", out, re.MULTILINE)
    assert all(name in out for name in shipped.studies())


def test_without_arguments_it_helps(capfd, monkeypatch):
    monkeypatch.setattr("sys.argv", ["luxloop"])
    assert main() == 0
    assert "Usage: luxloop" in capfd.readouterr().out


def luxloop(*arguments, **environment):
    """The real command, in a process of its own."""
    command = [str(Path(sys.executable).with_name("luxloop")), *arguments]
    return subprocess.run(command, env={**os.environ, **environment}, capture_output=True, text=True, check=False)


LATE = '<vehicle id="late" depart="10"><route edges="south_in north_out"/></vehicle>'


def test_a_sumo_error_in_mid_run_ends_it_there(tmp_path):
    """SUMO reads routes as it goes: it comes upon the unknown edge when the vehicle before it departs."""
    (tmp_path / "ego.rou.xml").write_text(f"<routes>{EGO}{LATE}{LOST}</routes>")
    (tmp_path / "a.toml").write_text(SUMO.replace("= 1\n", "= 20\n") + 'options = { route-steps = "1" }')
    run = luxloop("run", "a.toml", "--json")
    assert run.returncode == 3
    assert_kept(tmp_path / "runs" / "a-seed1", json.loads(run.stdout), json.loads(run.stdout)["frames"])
    assert json.loads(run.stdout)["frames"] * 0.08 > 5.0
    assert run.stderr.startswith("luxloop: error: SUMO")
    assert "edge 'nowhere'" in run.stderr
    assert "marked incomplete" in run.stderr
    assert run.stderr.count("\n") == 1


def test_an_ego_that_arrives_before_the_end_is_told(tmp_path):
    """It is put 30 m before the end of its only edge."""
    ego = '<vehicle id="ego" depart="0" departPos="-30" departSpeed="10"><route edges="north_out"/></vehicle>'
    (tmp_path / "ego.rou.xml").write_text(f"<routes>{ego}</routes>")
    (tmp_path / "a.toml").write_text(SUMO.replace("= 1\n", "= 20\n"))
    run = luxloop("run", "a.toml", "--json")
    assert run.returncode == 1
    assert_kept(tmp_path / "runs" / "a-seed1", json.loads(run.stdout), json.loads(run.stdout)["frames"])
    assert run.stderr.startswith('luxloop: error: ego "ego" left the net at ')
    assert run.stderr.count("\n") == 1


@pytest.mark.parametrize("scenario", ["sumo-crossing", "cruise-on-tracks"])
def test_a_run_outlives_its_simulator(scenario, tmp_path):
    """Traffic that runs ahead of the loop, and traffic that waits for its commands."""
    with running(scenario, "--duration", "600", "--json", "--out", "here") as run:
        os.kill(simulator_of(run), signal.SIGKILL)
        out, err = run.communicate(timeout=60)
    assert run.returncode == 3
    assert_kept(tmp_path / "here", json.loads(out), json.loads(out)["frames"])
    assert err.startswith("luxloop: error: SUMO's process died (signal 9) at ")
    assert err.endswith(f"the {json.loads(out)['frames']} frames until then are in here, marked incomplete\n")
    assert err.count("\n") == 1
    assert run_folder.read(tmp_path / "here").tables["truth"]["frame"].max() == json.loads(out)["frames"] - 1
    assert [path.name for path in tmp_path.iterdir()] == ["here"]


def test_ctrl_c_in_a_terminal_ends_run_and_simulator_with_one_line(tmp_path):
    """A terminal sends it to both processes."""
    with running("sumo-crossing", "--duration", "600", "--out", "here") as run:
        simulator = simulator_of(run)
        os.killpg(run.pid, signal.SIGINT)
        assert run.communicate(timeout=60) == ("", "luxloop: error: interrupted; nothing was written\n")
    assert run.returncode == 130
    assert not Path(f"/proc/{simulator}").exists()
    assert list(tmp_path.iterdir()) == []


def test_a_run_that_is_killed_takes_its_simulator_along_and_leaves_nothing_that_looks_whole(tmp_path):
    with running("sumo-crossing", "--duration", "600", "--out", "here") as run:
        simulator = simulator_of(run)
        run.kill()
    until(lambda: state_of(simulator) in ("Z", "gone"))
    assert [path.suffix for path in tmp_path.iterdir()] == [".partial"]
    assert list(tmp_path.rglob("result.json")) == []


@contextmanager
def running(*arguments):
    """The real command in a process group of its own, once it has recorded frames."""
    command = [str(Path(sys.executable).with_name("luxloop")), "run", *arguments]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, start_new_session=True, **pipes) as run:
        try:
            until(lambda: any(path.stat().st_size > 300_000 for path in Path().glob(".*.partial/recording.rrd")))
            yield run
        finally:
            run.kill()


def simulator_of(run):
    """Number of the only process that a run has started."""
    (child,) = [int(path.name) for path in Path("/proc").glob("[0-9]*") if parent_of(path.name) == run.pid]
    return child


def parent_of(pid):
    return int(stat_of(pid)[1]) if stat_of(pid) else None


def state_of(pid):
    return stat_of(pid)[0] if stat_of(pid) else "gone"


def stat_of(pid):
    """State, parent and so on, as the kernel tells them; nothing of a process that is gone."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except (FileNotFoundError, ProcessLookupError):
        return []


def until(condition, patience_s=60.0):
    end = time.monotonic() + patience_s
    while not condition():
        assert time.monotonic() < end, "it never came to that"
        time.sleep(0.05)


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
