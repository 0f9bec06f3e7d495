"""The command line: exit codes, errors on one line, no files left by failed runs, the same trace in every process."""

import json
import os
import re
import signal
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest
from support import short_run, warm_process
from support.breaking_traffic import break_at
from support.few import few
from support.processes import children_of, is_dead, until

from luxloop.scenarios.cli import main
from luxloop.scenarios.files import shipped
from luxloop.scenarios.report import first_screen
from luxloop.scenarios.run import run_folder
from luxloop.sim.source import SimulatorFailedError, TrafficEndedError

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
def _in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)


def tree(folder="."):
    return sorted(str(path) for path in Path(folder).rglob("*") if "__pycache__" not in path.parts)


@pytest.mark.parametrize(
    ("files", "arguments", "code", "message"),
    [
        ({}, ["missing.toml"], 2, "missing.toml: No such file or directory; give a readable file or a name"),
        ({}, ["rng"], 2, "rng: no such scenario; did you mean ring"),
        ({"a.toml": "sead = 1\n" + SUMO}, ["a.toml"], 2, "a.toml: sead = 1: unknown key; did you mean seed?"),
        ({"a.toml": SUMO.replace("= 1", '= "1"')}, ["a.toml"], 2, 'a.toml: duration_s = "1": should be a valid number'),
        ({"a.toml": SUMO.replace("= 1", "= -1")}, ["a.toml"], 2, "a.toml: duration_s = -1: should be greater than 0"),
        ({"a.toml": SUMO}, ["a.toml", "--duration", "-2"], 2, "a.toml: duration_s = -2.0: should be greater than 0"),
        ({"a.toml": SUMO}, ["a.toml"], 2, "ego.rou.xml: no such file"),
        (
            {"a.toml": SUMO.replace(":ego", ":absent"), "ego.rou.xml": f"<routes>{EGO}</routes>"},
            ["a.toml"],
            2,
            'a.toml: traffic: ego = "vehicle:absent" did not enter',
        ),
        pytest.param(
            {
                "a.toml": SUMO.replace(str(CROSSING / "crossing.net.xml"), "net.xml"),
                "net.xml": "<net",
                "ego.rou.xml": "",
            },
            ["a.toml"],
            2,
            "net.xml",
            marks=pytest.mark.slow,
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
        ({"a.toml": short_run.TEXT}, ["a.toml", "--tracker", "gone:Tracker"], 2, "no module gone on the Python path"),
        ({"a.toml": short_run.TEXT}, ["a.toml", "--seed", "one"], 2, "Invalid value for '--seed'"),
        ({"a.toml": short_run.TEXT}, ["a.toml", "--sead", "1"], 2, "No such option"),
        ({"a.toml": SUMO, "ego.rou.xml": f"<routes>{EGO}{LOST}</routes>"}, ["a.toml"], 2, "edge 'nowhere'"),
        ({"a.toml": SUMO.replace("vehicle:ego", "ego")}, ["a.toml"], 2, 'ego = "ego": write "vehicle:<id>", "route:'),
        ({"a.toml": SUMO + "dt_s = 0"}, ["a.toml"], 2, "a.toml: traffic: dt_s, max_wait_s and building_height_m must"),
        ({"a.toml": SUMO + "parking_fill = 1.5"}, ["a.toml"], 2, "a.toml: traffic: parking_fill = 1.5: write a share"),
        pytest.param(
            {
                "a.toml": SUMO + 'options = { extrapolate-departpos = "maybe" }',
                "ego.rou.xml": f"<routes>{EGO}</routes>",
            },
            ["a.toml"],
            2,
            "a.toml: traffic: ",
            marks=pytest.mark.slow,
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
def test_bad_input_is_one_line_on_standard_error_and_leaves_no_files(files, arguments, code, message, capfd):
    for name, content in files.items():
        Path(name).write_text(content, encoding="utf-8")
    before = tree()
    assert main(["run", *arguments]) == code
    out, err = capfd.readouterr()
    assert out == ""
    assert err.startswith("luxloop: error: ")
    assert err.count("\n") == 1
    assert message in err
    assert tree() == before


@pytest.mark.parametrize(
    "command",
    [
        ["run", "{}"], ["view", "{}"], ["report", "{}"], ["paper", "{}"], ["blame", "{}"], ["compare", "{}", "{}"],
        ["baseline", "{}"], ["trends", "{}"], ["grade", "{}"], ["mcap", "{}", "a.mcap"], ["track", "{}"],
        ["import", "{}", "--mount", "0,0,1"], ["sweep", "{}.toml"], ["search", "{}.toml"], ["realism", "{}"],
        ["occlusions", "{}"], ["thresholds", "{}.toml"], ["run", "short", "--tracker", "{}:Tracker"],
    ],
    ids=" ".join,
)  # fmt: skip
@pytest.mark.parametrize("name", ["n" * 300, "n/" * 3000], ids=["name", "path"])
def test_a_path_that_is_too_long_is_one_line(command, name, capfd):
    assert main([word.format(name) for word in command]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err.startswith("luxloop: error: ")
    assert err.count("\n") == 1


def test_an_output_folder_that_cannot_be_written_is_an_error_before_the_simulation(capfd):
    """The traffic is wrong as well; the error is of the folder, which is checked first."""
    Path("a.toml").write_text(SUMO.replace("vehicle:ego", "vehicle:absent"))
    Path("file").write_text("")
    assert main(["run", "a.toml", "--out", "file/run"]) == 2
    assert "file/run: cannot write there" in capfd.readouterr().err


def test_a_run_prints_its_first_screen_and_writes_its_folder(capfd):
    short_run.write(Path())
    assert main(["run", "short.toml", "--seed", "9"]) == 0
    out, err = capfd.readouterr()
    assert out.startswith(
        "NO LIMITS  short, seed 9: nothing in [expect] to pass or fail\n10 frames, 2 vehicles, tracker "
    )
    assert "\nluxloop view runs/short-seed9     the recording, at the worst frame\n" in out
    assert out.endswith("\nluxloop report runs/short-seed9   a page with pictures and all results\n")
    assert len(out.splitlines()) <= 20
    assert err == ""
    assert sorted(path.name for path in Path("runs/short-seed9").iterdir()) == [
        "recording.rrd", "report.txt", "result.json", "tables",
    ]  # fmt: skip
    assert "Fit heading error by method" in Path("runs/short-seed9/report.txt").read_text()


def test_full_prints_the_whole_report(capfd):
    short_run.write(Path(), short_run.TEXT + '[expect]\n"track.mota" = {max = 1}')
    assert main(["run", "short.toml", "--full", "--no-recording"]) == 0
    out = capfd.readouterr().out
    report = Path("runs/short-seed4/report.txt").read_text()
    assert out == report + "Results are in runs/short-seed4\n"
    assert "PASSED: 1 of 1 expectations hold" in report[:400]  # the answer comes first


def test_json_prints_the_result_only(capfd):
    short_run.write(Path())
    assert main(["run", "short.toml", "--json", "--no-recording", "--out", "here"]) == 0
    out, err = capfd.readouterr()
    document = json.loads(out)
    assert err == ""
    assert document["scenario"] == "short"
    assert document["seed"] == 4
    assert document["verdict"] == "no limits"
    assert document["failed"] == []
    assert document["complete"] is True
    assert document["out"] == "here"
    assert document["trace_hash"] == short_run.result().trace_hash
    assert document["metrics"]["mma.switch_latency_frames"]["value"] is None
    assert document["metrics"]["mma.switch_latency_frames"]["reason"]
    assert not Path("here/recording.rrd").exists()


def test_failed_expectations_exit_with_1_and_keep_the_run(capfd):
    limits = '"track.idf1" = {min = 1.01}\n"track.hota" = {max = -0.01}\n"track.mota" = {max = 1}'
    short_run.write(Path(), f"{short_run.TEXT}[expect]\n{limits}")
    assert main(["run", "short.toml", "--json", "--no-recording"]) == 1
    document = json.loads(capfd.readouterr().out)
    assert document["verdict"] == "failed"
    assert document["failed"] == ["track.idf1", "track.hota"]
    assert json.loads(Path("runs/short-seed4/result.json").read_text())["verdict"] == "failed"


def test_an_expectation_on_a_metric_without_a_value_fails(capfd):
    short_run.write(Path(), short_run.TEXT + '[expect]\n"mma.switch_latency_frames" = {max = 1000}')
    assert main(["run", "short.toml", "--no-recording"]) == 1
    out = capfd.readouterr().out
    assert out.startswith("FAILED  short, seed 4: 0 of 1 expectations hold, 1 failed\n")
    assert "mma.switch_latency_frames n/a, not <= 1000 no followed vehicle changed its mode" in " ".join(out.split())


ENDS = pytest.mark.parametrize(
    ("error", "code"), [(TrafficEndedError("the ego left"), 1), (SimulatorFailedError("it gave\n  up."), 3)]
)


@ENDS
def test_a_run_without_a_frame_leaves_no_folder(error, code, monkeypatch, capfd):
    """Traffic that ends before the first frame is an error of the scenario."""
    break_at(0, error, monkeypatch)
    short_run.write(Path())
    before = tree()
    assert main(["run", "short.toml"]) == {1: 2, 3: 3}[code]
    assert capfd.readouterr() == ("", f"luxloop: error: {' '.join(str(error).split())}\n")
    assert tree() == before


@ENDS
def test_a_run_that_ends_early_keeps_its_frames_and_does_not_pass(error, code, monkeypatch, capfd):
    """Its expectation holds over its frames; the missing ones could be the hard ones."""
    break_at(4, error, monkeypatch)
    short_run.write(Path(), short_run.TEXT + '[expect]\n"track.mota" = {max = 1}')
    assert main(["run", "short.toml", "--json", "--out", "here"]) == code
    out, err = capfd.readouterr()
    assert_kept(Path("here"), json.loads(out), frames=4)
    assert set(run_folder.read(Path("here")).tables["truth"]["frame"]) == set(range(4))
    assert json.loads(out)["simulator_failed"] is (code == 3)
    reason = " ".join(str(error).split()).removesuffix(".")
    assert err.startswith(f"luxloop: error: {reason}; ")
    assert err.endswith("; the 4 frames until then are in here, marked incomplete\n")
    assert err.count("\n") == 1


def assert_kept(folder, document, frames):
    """Check that result, report, tables and recording agree on an incomplete run of a number of frames."""
    assert document["verdict"] == "incomplete"  # even if its expectations hold over these frames
    assert document["complete"] is False
    assert document["ended_early"]
    assert document["frames"] == frames > 0
    written = json.loads((folder / "result.json").read_text())
    assert written == {key: value for key, value in document.items() if key != "out"}
    assert "INCOMPLETE" in (folder / "report.txt").read_text()
    assert (run_folder.read(folder).tables["truth"]["frame"] < frames).all()
    rerun = [sys.executable, "-m", "rerun_cli", "rrd", "verify", str(run_folder.recording(folder))]
    assert subprocess.run(rerun, capture_output=True, check=False).returncode == 0


def test_an_incomplete_run_prints_its_report_and_an_error_line(monkeypatch, capfd):
    break_at(4, TrafficEndedError("the ego left"), monkeypatch)
    short_run.write(Path())
    assert main(["run", "short.toml", "--no-recording"]) == 1
    out, err = capfd.readouterr()
    assert out.startswith("INCOMPLETE  short, seed 4: ended early: the ego left; so far nothing in [expect] to pass or")
    assert "luxloop report runs/short-seed4" in out
    assert err == (
        "luxloop: error: the ego left; give the ego a longer route, or the run a shorter --duration; "
        "the 4 frames until then are in runs/short-seed4, marked incomplete\n"
    )


INTERRUPTED = """
import signal

class Tracker:
    def __init__(self, config):
        pass
    def step(self, scan):
        signal.raise_signal(signal.SIGINT)
"""
INSIDE_EXEC = 'exec("signal.raise_signal(signal.SIGINT)")'
AS_NUMBA = """
        try:
            signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt as error:
            raise SystemError from error
"""


def test_ctrl_c_prints_a_line_and_leaves_no_files(capfd):
    short_run.write(Path())
    Path("impatient.py").write_text(INTERRUPTED)
    before = tree()
    assert main(["run", "short.toml", "--tracker", "impatient:Tracker", "--in-process"]) == 130
    assert capfd.readouterr().err == "luxloop: error: interrupted; nothing was written\n"
    assert tree() == before


def test_ctrl_c_that_numba_turns_into_another_error_is_recognised(capfd):
    """numba does so while it loads a kernel."""
    short_run.write(Path())
    Path("loading.py").write_text(INTERRUPTED.replace("\n        signal.raise_signal(signal.SIGINT)\n", AS_NUMBA))
    assert main(["run", "short.toml", "--tracker", "loading:Tracker", "--in-process"]) == 130
    assert capfd.readouterr().err == "luxloop: error: interrupted; nothing was written\n"


def test_ctrl_c_inside_a_string_of_exec_keeps_the_exit_code():
    """CPython would end the process by SIGINT, without its exit code; `dataclass` uses such strings."""
    short_run.write(Path())
    Path("making.py").write_text(INTERRUPTED.replace("signal.raise_signal(signal.SIGINT)", INSIDE_EXEC))
    ended = warm_process.luxloop(
        "run", "short.toml", "--tracker", "making:Tracker", "--in-process", delete_modules=True
    )
    assert (ended.returncode, ended.stderr) == (130, "luxloop: error: interrupted; nothing was written\n")


def test_sigterm_within_a_tracker_ends_the_run(capfd):
    """The tracker must not be blamed for the interrupt that it sees."""
    short_run.write(Path())
    Path("ended.py").write_text(INTERRUPTED.replace("SIGINT", "SIGTERM"))
    before = signal.getsignal(signal.SIGTERM)
    assert main(["run", "short.toml", "--tracker", "ended:Tracker", "--in-process"]) == 143
    assert capfd.readouterr().err == "luxloop: error: interrupted; nothing was written\n"
    assert signal.getsignal(signal.SIGTERM) is before


def test_ctrl_c_after_the_folder_is_whole_names_it(monkeypatch, capfd):
    monkeypatch.setattr(first_screen, "show", lambda *_: signal.raise_signal(signal.SIGINT))
    short_run.write(Path())
    assert main(["run", "short.toml", "--no-recording", "--out", "whole"]) == 130
    whole = Path("whole").resolve()
    assert capfd.readouterr().err == f"luxloop: error: interrupted; complete and kept: {whole}\n"
    assert run_folder.read(whole).frames == short_run.FRAMES


def test_view_needs_a_run(capfd):
    assert main(["view", "nowhere"]) == 2
    assert "no result.json of a run in it" in capfd.readouterr().err


def test_list_prints_every_scenario_with_its_family(capfd):
    assert main(["list"]) == 0
    out = capfd.readouterr().out
    for entry in shipped.entries():
        assert entry.name in out
        assert entry.family in out


def test_list_prints_every_study_with_its_command(capfd):
    assert main(["list", "--studies"]) == 0
    out = capfd.readouterr().out
    for command, study in (("sweep", "occlusion"), ("search", "lost-behind-wall")):
        assert re.search(rf"^{command} +{study} ", out, re.MULTILINE)
    assert all(name in out for name in shipped.studies())


def test_without_arguments_it_prints_the_help(capfd, monkeypatch):
    monkeypatch.setattr("sys.argv", ["luxloop"])
    assert main() == 0
    assert "Usage: luxloop" in capfd.readouterr().out


def luxloop(*arguments, **environment):
    """Run the installed command in a process of its own."""
    command = [str(Path(sys.executable).with_name("luxloop")), *arguments]
    return subprocess.run(command, env={**os.environ, **environment}, capture_output=True, text=True, check=False)


LATE = '<vehicle id="late" depart="4"><route edges="south_in north_out"/></vehicle>'


def test_a_sumo_error_during_the_run_ends_it_early(tmp_path, capfd):
    """SUMO reads routes step by step: it meets the unknown edge when the previous vehicle departs."""
    (tmp_path / "ego.rou.xml").write_text(f"<routes>{EGO}{LATE}{LOST}</routes>")
    (tmp_path / "a.toml").write_text(SUMO.replace("= 1\n", "= 20\n") + 'options = { route-steps = "1" }')
    assert main(["run", "a.toml", "--json"]) == 3
    out, err = capfd.readouterr()
    assert_kept(tmp_path / "runs" / "a-seed1", json.loads(out), json.loads(out)["frames"])
    assert json.loads(out)["frames"] * 0.08 > 0.5
    assert err.startswith("luxloop: error: SUMO")
    assert "edge 'nowhere'" in err
    assert "marked incomplete" in err
    assert err.count("\n") == 1


def test_an_ego_that_arrives_early_is_an_error_line(tmp_path, capfd):
    """The ego starts 10 m before the end of its only edge."""
    ego = '<vehicle id="ego" depart="0" departPos="-10" departSpeed="10"><route edges="north_out"/></vehicle>'
    (tmp_path / "ego.rou.xml").write_text(f"<routes>{ego}</routes>")
    (tmp_path / "a.toml").write_text(SUMO.replace("= 1\n", "= 20\n"))
    assert main(["run", "a.toml", "--json"]) == 1
    out, err = capfd.readouterr()
    assert_kept(tmp_path / "runs" / "a-seed1", json.loads(out), json.loads(out)["frames"])
    assert err.startswith('luxloop: error: ego "ego" left the net at ')
    assert err.count("\n") == 1


@pytest.mark.slow
@pytest.mark.parametrize("scenario", ["sumo-crossing", "cruise-on-tracks"])
def test_a_run_survives_the_death_of_its_simulator(scenario, tmp_path):
    """With traffic that is computed ahead of the loop, and with traffic that waits for its commands."""
    with running(scenario, "--duration", "600", "--json", "--out", "here") as run:
        (simulator,) = children_of(run.pid)
        os.kill(simulator, signal.SIGKILL)
        out, err = run.communicate(timeout=60)
    assert run.returncode == 3
    assert_kept(tmp_path / "here", json.loads(out), json.loads(out)["frames"])
    assert err.startswith("luxloop: error: SUMO's process died (signal 9) at ")
    assert err.endswith(f"the {json.loads(out)['frames']} frames until then are in here, marked incomplete\n")
    assert err.count("\n") == 1
    assert run_folder.read(tmp_path / "here").tables["truth"]["frame"].max() == json.loads(out)["frames"] - 1
    assert [path.name for path in tmp_path.iterdir()] == ["here"]


@pytest.mark.parametrize(
    ("number", "code"),
    [
        (signal.SIGINT, 130),
        pytest.param(signal.SIGTERM, 143, marks=pytest.mark.slow),
        pytest.param(signal.SIGHUP, 129, marks=pytest.mark.slow),
    ],
)
def test_a_signal_of_a_terminal_ends_run_and_simulator_with_one_line(number, code, tmp_path):
    """A terminal sends the signal to both processes."""
    with running("sumo-crossing", "--duration", "600", "--out", "here") as run:
        (simulator,) = children_of(run.pid)
        os.killpg(run.pid, number)
        out, err = run.communicate(timeout=60)
    assert (run.returncode, out, err) == (code, "", "luxloop: error: interrupted; nothing was written\n")
    assert not Path(f"/proc/{simulator}").exists()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_the_simulator_of_a_killed_run_ends_and_no_result_is_left(tmp_path):
    with running("sumo-crossing", "--duration", "600", "--out", "here") as run:
        (simulator,) = children_of(run.pid)
        run.kill()
    until(lambda: is_dead(simulator))
    assert [path.suffix for path in tmp_path.iterdir()] == [".partial"]
    assert list(tmp_path.rglob("result.json")) == []


@contextmanager
def running(*arguments):
    """Yield `luxloop run` in a process group of its own, once it has recorded frames."""
    with warm_process.started("luxloop", "run", *arguments) as run:
        until(lambda: any(path.stat().st_size > 300_000 for path in Path().glob(".*.partial/recording.rrd")))
        yield run


def test_list_imports_no_slow_package():
    code = "import sys; from luxloop.scenarios.cli import main; main(['list']); print(*sys.modules)"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    heavy = {"numpy", "pandas", "numba", "libsumo", "highway_env", "rerun"}
    assert heavy.isdisjoint(out.splitlines()[-1].split())


@pytest.mark.parametrize("scenario", few(["sumo-crosing", "missing.toml", "broken.toml"], "sumo-crosing"))
def test_a_misspelt_scenario_is_reported_before_slow_packages_are_imported(scenario, tmp_path):
    (tmp_path / "broken.toml").write_text("duration_s = \n")
    code = (
        f"import sys; from luxloop.scenarios.cli import main; print(main(['run', {scenario!r}])); print(*sys.modules)"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path)
    exit_code, modules = ran.stdout.splitlines()
    assert (exit_code, len(ran.stderr.splitlines())) == ("2", 1)
    assert {"pandas", "numba", "scipy", "matplotlib", "rerun"}.isdisjoint(modules.split())


@pytest.mark.slow
def test_the_trace_is_the_same_in_any_process_under_any_hash_seed(capfd, monkeypatch):
    """SUMO returns its vehicles in dicts and sets keyed by their names."""
    arguments = ("run", "sumo-crossing", "--duration", "1", "--no-recording", "--json")
    assert warm_process.HASH_SEED != "1"
    with monkeypatch.context() as patch:
        patch.setenv("PYTHONHASHSEED", warm_process.HASH_SEED)  # of the simulator's process
        runs = [luxloop(*arguments, PYTHONHASHSEED="1"), warm_process.luxloop(*arguments)]
    assert main(list(arguments)) in (0, 1)
    documents = [json.loads(run.stdout) for run in runs] + [json.loads(capfd.readouterr().out)]
    assert [run.stderr for run in runs] == ["", ""]
    assert len({document["trace_hash"] for document in documents}) == 1
    assert main([*arguments, "--seed", "2"]) in (0, 1)
    assert json.loads(capfd.readouterr().out)["trace_hash"] != documents[0]["trace_hash"]


def test_the_installed_command_returns_its_exit_code():
    run = luxloop("run", "missing.toml")
    assert (run.returncode, run.stdout) == (2, "")
    assert run.stderr.startswith("luxloop: error: missing.toml")
