"""`luxloop run`: set keys, several seeds, quiet, and names of default folders."""

import json
import re
import statistics
from pathlib import Path

import pytest
from support import short_run

from luxloop.scenarios.cli import main
from luxloop.scenarios.execute import default_folder, file_name
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.report.html.reported_run import ReportedRun
from luxloop.scenarios.run import run_folder


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    short_run.write(tmp_path)


def run(*arguments):
    return main(["run", "short.toml", "--no-recording", *arguments])


def test_set_key_is_in_the_configuration_the_folder_and_the_command_of_the_run(capfd):
    assert run("--set", "noise.ideal=true", "--set", "traffic.actor[0].x_m=11", "--json") == 0
    document = json.loads(capfd.readouterr().out)
    assert document["config"]["noise"]["ideal"] is True
    assert document["config"]["traffic"]["actor"][0]["x_m"] == 11.0
    assert document["config"]["set"] == ["noise.ideal=true", "traffic.actor[0].x_m=11"]
    out = Path(document["out"])
    assert out.name.startswith("short-seed4-noise.ideal=true-traffic.actor-0-.x_m=11-")
    again = ReportedRun.read(out).commands[0]
    assert "--set noise.ideal=true --set 'traffic.actor[0].x_m=11'" in again
    assert document["trace_hash"] != short_run.result().trace_hash


def test_scans_of_a_run_with_set_keys_are_graded_again(capfd):
    assert run("--set", "noise.ideal=true", "--record-scans", "--out", "here") == 0
    assert main(["grade", "here", "--tracker", "luxloop.tracker.tracker:Tracker", "--json"]) == 0
    out = capfd.readouterr().out.splitlines()[-1]
    assert (
        json.loads(out)["metrics"]["track.hota"]["value"] == run_folder.read(Path("here")).metrics["track.hota"].value
    )


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("noise.rane.enabled=true", "short.toml: noise.rane = "),
        ("noise", "--set noise: should be KEY=VALUE"),
        ("duration_s=-1", "short.toml: duration_s = -1: should be greater than 0"),
        ("seed.x=1", "--set seed.x=1: seed is a single value"),
    ],
)
def test_bad_setting_is_one_line_and_writes_nothing(setting, message, capfd):
    assert run("--set", setting) == 2
    out, err = capfd.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert message in err
    assert sorted(path.name for path in Path().iterdir()) == ["short.toml"]


def test_quiet_run_prints_nothing_and_keeps_its_exit_code(capfd):
    assert run("--quiet") == 0
    assert run("-q", "--seeds", "1-2", "--set", 'expect."track.hota".min=2') == 1
    assert capfd.readouterr() == ("", "")
    assert Path("runs/short-seed4/result.json").exists()


def test_seeds_have_a_folder_each_and_a_table_of_means_and_spreads(capfd):
    assert run("--seeds", "3-4", "--out", "all", "--full") == 0
    out, err = capfd.readouterr()
    assert err.splitlines() == [f"seed {n}: no limits; the results are in all/short-seed{n}" for n in (3, 4)]
    assert sorted(path.name for path in Path("all").iterdir()) == [f"short-seed{seed}" for seed in (3, 4)]
    results = [run_folder.read(Path("all") / f"short-seed{seed}") for seed in (3, 4)]
    assert [result.seed for result in results] == [3, 4]
    values = [result.metrics["fit.heading_abs_mean_deg"].value for result in results]
    line = next(line for line in out.splitlines() if line.startswith("fit.heading_abs_mean_deg"))
    expected = (statistics.fmean(values), statistics.stdev(values), min(values), max(values))
    assert line.split()[1:] == [*(f"{value:.3f}" for value in expected), "2"]


def test_seeds_are_one_screen(capfd):
    """Seeds with the worst verdict come first; the limits name the worst seed and value."""
    limits = ('expect."track.hota".min=2', 'expect."track.mota".max=1', 'expect."track.idf1".min=1.5')
    settings = [word for limit in limits for word in ("--set", limit)]
    assert run("--seeds", "3-5", "--out", "all", *settings) == 1
    out = capfd.readouterr().out
    results = [run_folder.read(path) for path in sorted(Path("all").iterdir())]
    hota = [result.metrics["track.hota"].value for result in results]
    assert out.startswith("FAILED  short, seeds 3-5: 3 failed\n")
    assert len(out.splitlines()) <= 20
    lines = [line.split() for line in out.splitlines()]
    shown = next(line for line in lines if line[:1] == ["HOTA,"])
    assert shown[-4:] == [
        f"{one:.3f}" for one in (statistics.fmean(hota), statistics.stdev(hota), min(hota), max(hota))
    ]
    row = next(line for line in lines if line[:1] == ["track.hota"])
    worst = 3 + hota.index(min(hota))
    assert row == ["track.hota", f"{min(hota):.3f}", "<", "2", "3", "of", "3", "seeds,", "worst:", str(worst)]
    assert not any(line[:1] == ["track.mota"] for line in lines)
    assert re.search(r"^luxloop report all/short-seed3\S+$", out, re.MULTILINE)


BROKEN_AT_SEED_2 = """\
from luxloop.tracker.tracker import Tracker as Shipped

made = 0


class Tracker(Shipped):
    def __init__(self, config):
        global made
        made += 1
        super().__init__(config)
        self.number = made

    def step(self, scan):
        if self.number == 4:  # every run makes two trackers
            raise ValueError("broken")
        return super().step(scan)
"""


def test_the_worst_seed_sets_the_exit_code_and_the_others_are_kept(capfd):
    Path("mine.py").write_text(BROKEN_AT_SEED_2)
    assert run("--seeds", "1-3", "--tracker", "mine.py:Tracker", "--in-process", "--json") == 4
    out, err = capfd.readouterr()
    document = json.loads(out)
    assert (document["exit_code"], [run["seed"] for run in document["runs"]]) == (4, [1, 3])
    assert [error["seed"] for error in document["errors"]] == [2]
    assert err.count("\n") == 1
    assert err.startswith("luxloop: error: seed 2: ")
    assert document["summary"]["track.hota"]["seeds"] == 2
    assert {Path(run["out"]).name for run in document["runs"]} == {"short-seed1-Tracker", "short-seed3-Tracker"}


def test_ctrl_c_names_the_seeds_that_are_kept(capfd):
    broken = 'raise ValueError("broken")'
    assert broken in BROKEN_AT_SEED_2
    interrupted = BROKEN_AT_SEED_2.replace(broken, "signal.raise_signal(signal.SIGINT)")
    Path("stopped.py").write_text("import signal\n" + interrupted)
    assert run("--seeds", "1-3", "--tracker", "stopped.py:Tracker", "--in-process") == 130
    error = capfd.readouterr().err.splitlines()[-1]
    assert error == "luxloop: error: interrupted at seed 2; the runs of seeds 1 are kept"
    assert [path.name for path in Path("runs").iterdir()] == ["short-seed1-Tracker"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--seeds", "6-1"], "--seeds 6-1: give one seed, or the first and the last"),
        (["--seeds", "1-x"], "--seeds 1-x: give one seed"),
        (["--seeds", "1-2", "--seed", "3"], "--seed and --seeds are both given"),
        (["--seeds", "1-2", "--dataset", "data"], "--seeds and --dataset are both given"),
        (["--seeds", "1-99999999999"], "--seeds 1-99999999999: more than 10000 seeds; run them in parts"),
    ],
)
def test_bad_seeds_are_one_line_and_run_nothing(arguments, message, capfd):
    assert run(*arguments) == 2
    out, err = capfd.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert message in err
    assert not Path("runs").exists()


def test_default_folders_of_different_runs_are_different():
    scenario = Scenario.load(Path("short.toml"))
    names = [
        default_folder(scenario).name,
        default_folder(scenario, ["fit"]).name,
        default_folder(scenario, [], "docs.examples.my_tracker:PatchTracker").name,
        default_folder(scenario, [], "process:/opt/my tracker --fast").name,
        default_folder(Scenario.load(Path("short.toml"), {}, ["noise.ideal=true"])).name,
    ]
    assert names == [
        "short-seed4",
        "short-seed4-oracle-fit",
        "short-seed4-PatchTracker",
        "short-seed4-my",
        "short-seed4-noise.ideal=true",
    ]
    assert default_folder(scenario, [], "luxloop.tracker.tracker:Tracker").name == "short-seed4"


def test_part_of_a_file_name_is_short_without_separators_and_unique():
    assert file_name("a.b=1") == "a.b=1"
    assert file_name("../x") != file_name("..:x")
    assert "/" not in file_name("../x")
    assert len(file_name("x" * 500)) < 64
    assert file_name("x" * 500) != file_name("x" * 501)


@pytest.mark.slow
def test_warm_up_compiles_and_writes_nothing(capfd):
    assert main(["warm-up", "short.toml"]) == 0
    assert "The kernels are ready, after " in capfd.readouterr().out
    assert sorted(path.name for path in Path().iterdir()) == ["short.toml"]
    assert main(["warm-up", "short.toml", "--quiet"]) == 0
    assert capfd.readouterr() == ("", "")


@pytest.mark.slow
def test_brackets_in_every_text_of_a_scenario_are_printed_as_written(capfd):
    limit = (
        '"track.hota" = { min = 2.0, need = "limits are in [/docs/x.md]", known_failure = "0.5: [red]why[/red] [/x]" }'
    )
    text = short_run.TEXT.replace("[bold]", "[/bold] :car:") + f"[expect]\n{limit}\n"
    short_run.write(Path(), text)
    run("--full")
    out = " ".join(capfd.readouterr().out.split())
    assert "standing ego [/bold] :car:" in out
    assert "[red]why[/red] [/x]" in out
    assert main(["grade", "runs/short-seed4"]) == 0
    assert "  [red]why[/red] [/x]\n" in capfd.readouterr().out
    assert main(["report", "runs/short-seed4"]) == 0
    page = Path("runs/short-seed4.html").read_text(encoding="utf-8")
    assert "limits are in [/docs/x.md]" in page
