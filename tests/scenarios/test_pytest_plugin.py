"""pytest on a folder of scenarios: messages, JUnit file, run folders, and equal results on all workers."""

import json
import re
import shlex
import shutil
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import NamedTuple

import pytest
from support import made_once, short_run, warm_process
from support.few import few

from luxloop.scenarios.cli import main
from luxloop.scenarios.files import shipped
from luxloop.scenarios.run import run_folder

CROSSING = shipped.CATALOG / "urban" / "sumo-crossing"
SUMO = f"""\
description = "The signalised crossing, for ten frames."
duration_s = 0.8
[traffic]
kind = "sumo"
net = "{CROSSING}/crossing.net.xml"
routes = ["{CROSSING}/crossing.rou.xml"]
ego = "vehicle:ego"
"""
HIGHWAY = """\
description = "A highway, for ten frames."
duration_s = 0.8
[traffic]
kind = "highway-env"
env = "highway-v0"
config = { vehicles_count = 10 }
"""
SUITE = {
    "holds": 'suite = "smoke"\n' + short_run.TEXT + '[expect]\n"track.mota" = { max = 1.0 }',
    "fails": short_run.TEXT
    + """
[expect]
"fit.heading_abs_mean_deg" = { max = 0.001, unit = "deg", need = "a ruler's edge" }
"track.false" = { max = 1000 }
"mma.switch_latency_frames" = { max = 3 }
""",
    "known": short_run.TEXT + '[expect]\n"track.idf1" = { min = 1.5, known_failure = "the parked car is [one] piece" }',
    "better": short_run.TEXT + '[expect]\n"track.mota" = { max = 1.0, known_failure = "it was bad once" }',
    "broken": short_run.TEXT.replace("seed = 4", 'seed = "four"'),
    "torn": short_run.TEXT[:-20] + '"',
    "left/twin": short_run.TEXT,
    "right/twin": short_run.TEXT.replace("speed_mps = 5", "speed_mps = 6"),
    "crossing": SUMO,
    "highway": HIGHWAY,
}
FAILED, XFAILED = {"fails-seed4", "broken", "torn-seed1"}, {"known-seed4"}
SHUFFLE = """\
import random
def pytest_collection_modifyitems(items):
    random.Random(5).shuffle(items)
"""
BLIND = """\
from luxloop.tracker.tracker import Tracker
class Blind(Tracker):
    def step(self, scan):
        return super().step(type(scan).from_points(scan.time, [], scan.ego_pose_odom))[0]  # a trace has all points
"""


JUNIT = "junit.xml"


class Session(NamedTuple):
    """Results of a pytest session."""

    code: int
    out: str
    cases: dict[str, ET.Element]
    """Test cases by file and name."""


def session(folder: Path, *arguments: str) -> Session:
    """Run pytest in a process of its own, in a folder that is its root."""
    run = warm_process.run("pytest", "-p", "no:cacheprovider", f"--junitxml={folder / JUNIT}", *arguments, cwd=folder)
    return Session(run.returncode, run.stdout + run.stderr, cases_in(folder))


def cases_in(folder: Path) -> dict[str, ET.Element]:
    """Return the test cases of the last session in a folder."""
    junit = folder / JUNIT
    cases = ET.parse(junit).getroot().iter("testcase") if junit.exists() else ()
    return {f"{case.get('classname')}/{case.get('name')}": case for case in cases}


def traces(session: Session) -> dict[str, str | None]:
    return {name: properties(case).get("trace_hash") for name, case in session.cases.items()}


def properties(case: ET.Element) -> dict[str, str]:
    return {entry.get("name", ""): entry.get("value", "") for entry in case.iter("property")}


def write_suite(folder: Path) -> Path:
    (folder / "pytest.ini").write_text("[pytest]\n")
    (folder / "unit.toml").write_text("[unit]\nrange_max_m = 3\n")  # not a scenario
    for name, text in SUITE.items():
        path = folder / f"{name}.toml"
        path.parent.mkdir(exist_ok=True)
        short_run.write(path.parent, text, path.stem)
    return folder


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return made_once.folder(tmp_path_factory, "suite", run_suite)


def run_suite(folder):
    run = session(write_suite(folder), "-rxX")
    (folder / "session.json").write_text(json.dumps([run.code, run.out]))


@pytest.fixture(scope="module")
def suite(folder):
    return Session(*json.loads((folder / "session.json").read_text()), cases_in(folder))


def test_every_scenario_is_a_case_with_its_outcome(suite):
    failed = {name.rpartition("/")[2] for name, case in suite.cases.items() if case.find("failure") is not None}
    skipped = {name.rpartition("/")[2] for name, case in suite.cases.items() if case.find("skipped") is not None}
    assert len(suite.cases) == len(SUITE)
    assert (failed, skipped) == (FAILED, XFAILED)
    assert suite.code == 1
    assert "3 failed, 5 passed, 1 xfailed, 1 xpassed" in suite.out
    assert "XFAIL known.toml::known-seed4 - track.idf1: the parked car is [one] piece" in suite.out
    assert "XPASS better.toml::better-seed4 - track.mota: it was bad once" in suite.out


def test_a_case_has_its_metrics_as_properties(suite, folder):
    recorded = properties(suite.cases["fails.toml/fails-seed4"])
    run = run_folder.read(folder / "runs" / "fails-seed4")
    assert recorded["seed"] == "4"
    assert recorded["trace_hash"] == run.trace_hash
    assert float(recorded["fit.heading_abs_mean_deg"]) == run.metrics["fit.heading_abs_mean_deg"].value
    assert recorded["mma.switch_latency_frames"] == "n/a"
    assert recorded["folder"] == "runs/fails-seed4"
    assert set(recorded) == {"seed", "trace_hash", "folder", *run.config["expect"]}


def test_a_failure_names_metric_value_limit_need_and_worst_frames(suite, folder):
    text = suite.cases["fails.toml/fails-seed4"].find("failure").text
    run = run_folder.read(folder / "runs" / "fails-seed4")
    value = run.metrics["fit.heading_abs_mean_deg"].value
    fits = run.tables["fits"]
    worst = fits[fits["best"]].assign(off=lambda rows: rows["heading_error_deg"].abs()).sort_values("off").iloc[-1]
    assert f"fit.heading_abs_mean_deg = {value:.3f} deg, expected <= 0.001 deg\n    a ruler's edge\n" in text
    assert f"    worst: frame {worst['frame']} ({worst['time_s']:.2f} s): the {worst['method']} rectangle " in text
    assert "mma.switch_latency_frames = n/a, expected <= 3\n    no followed vehicle changed its mode\n\n" in text
    assert "track.false" not in text  # it holds
    assert text in suite.out


def test_the_commands_of_a_failure_run(suite, folder, tmp_path, monkeypatch, capfd):
    """The first repeats the run with a recording, the second shows that recording."""
    monkeypatch.chdir(shutil.copytree(folder, tmp_path / "copy"))
    text = suite.cases["fails.toml/fails-seed4"].find("failure").text
    again, view = [shlex.split(line) for line in re.findall(r"^    (luxloop .*)$", text, re.MULTILINE)]
    before = run_folder.read(Path("runs/fails-seed4"))
    assert main([*again[1:], "--json"]) == 1
    assert run_folder.read(Path("runs/fails-seed4")).trace_hash == before.trace_hash
    assert view[:2] == ["luxloop", "view"]
    assert run_folder.recording(Path(view[2])).stat().st_size > 0
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize(
    ("case", "message"),
    [
        ("broken.toml/broken", 'broken.toml: seed = "four": should be a valid integer'),
        ("torn.toml/torn-seed1", "torn.toml: not TOML: "),
    ],
)
def test_a_malformed_file_fails_alone_with_one_line(suite, folder, case, message):
    text = suite.cases[case].find("failure").text
    assert text.startswith(f"{folder}/{message}")
    assert "\n" not in text
    assert "Traceback" not in suite.out


def test_files_of_one_name_have_folders_of_their_own(suite, folder):
    left, right = (run_folder.read(folder / "runs" / side / "twin-seed4") for side in ("left", "right"))
    assert left.trace_hash != right.trace_hash
    assert properties(suite.cases["left.twin.toml/twin-seed4"])["trace_hash"] == left.trace_hash
    assert properties(suite.cases["right.twin.toml/twin-seed4"])["trace_hash"] == right.trace_hash


@pytest.mark.slow
def test_workers_and_order_change_no_trace(suite, tmp_path):
    """In another folder, shuffled or by two workers, SUMO, highway-env and scripted traffic are bit-identical."""
    (write_suite(tmp_path) / "conftest.py").write_text(SHUFFLE)
    other = session(tmp_path, "-v")
    order = re.findall(r"^(\S+)::\S+ (?:PASSED|FAILED|XFAIL|XPASS) ", other.out, re.MULTILINE)
    assert len(order) == len(SUITE)
    assert order != sorted(order)
    hashes = traces(suite)
    assert traces(other) == hashes
    assert traces(session(tmp_path, "-n", "2")) == hashes
    assert len(set(hashes.values())) == 5  # the short scenario and its faster twin, crossing, highway, and none


@pytest.mark.slow
def test_another_tracker_on_two_seeds_and_the_first_failure_ends_it(tmp_path):
    (write_suite(tmp_path) / "mine.py").write_text(BLIND)
    arguments = ("-x", "-k", "fails or twin", "--luxloop-seeds", "2", "--luxloop-tracker", "mine:Blind")
    run = session(tmp_path, *arguments, "--luxloop-out", "out", "--luxloop-record", "left", "fails.toml")
    assert [*run.cases] == ["left.twin.toml/twin-seed4", "left.twin.toml/twin-seed5", "fails.toml/fails-seed4"]
    assert "stopping after 1 failures" in run.out
    blind = run_folder.read(tmp_path / "out" / "left" / "twin-seed5")
    assert blind.config["device"] == "mine:Blind"
    assert blind.metrics["track.mota"].value == 0.0
    assert run_folder.recording(tmp_path / "out" / "left" / "twin-seed5").stat().st_size > 0
    assert "--out out/fails-seed4 --tracker mine:Blind" in run.out


@pytest.mark.parametrize(
    ("arguments", "chosen"),
    [
        (["-m", "smoke"], {"holds.toml::holds-seed4"}),
        pytest.param(
            ["-m", "full", "-k", "twin"],
            {"left/twin.toml::twin-seed4", "right/twin.toml::twin-seed4"},
            marks=pytest.mark.slow,
        ),
        (["-k", "holds", "--luxloop-seeds", "3"], {f"holds.toml::holds-seed{seed}" for seed in (4, 5, 6)}),
        # A file that is named is run in any case.
        pytest.param(["unit.toml"], {"unit.toml::unit-seed1"}, marks=pytest.mark.slow),
    ],
)
def test_markers_options_and_names_select_the_tests(tmp_path, arguments, chosen):
    run = session(write_suite(tmp_path), "--collect-only", "-q", *arguments)
    assert {line for line in run.out.splitlines() if "::" in line} == chosen


@pytest.mark.parametrize("count", few(["0", "-1", "some"], "0"))
def test_a_suite_without_seeds_is_refused(tmp_path, count):
    run = session(write_suite(tmp_path), "--luxloop-seeds", count)
    assert run.code == pytest.ExitCode.USAGE_ERROR
    assert f"'{count}' should be a whole number, 1 or more" in run.out


DEFECT = """\
from luxloop.scenarios.grading.grader import Grader

def fail(*_):
    raise ZeroDivisionError("planted")

Grader.add = fail
"""


@pytest.mark.parametrize("workers", [(), pytest.param(("-n", "1"), marks=pytest.mark.slow)])
def test_a_defect_of_luxloop_is_an_error_of_the_test_and_no_failure(tmp_path, workers):
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    (tmp_path / "conftest.py").write_text(DEFECT)
    short_run.write(tmp_path)
    run = session(tmp_path, "--luxloop-report", "luxloop.html", *workers)
    (case,) = run.cases.values()
    assert case.find("failure") is None
    assert "ZeroDivisionError: planted" in case.find("error").text
    assert "1 error in" in run.out
    assert "this is a defect of luxloop: report it with the traceback above" in run.out
    assert "ZeroDivisionError: planted" in (tmp_path / "luxloop.html").read_text()
