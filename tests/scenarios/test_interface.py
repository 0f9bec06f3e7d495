"""`import luxloop`: runs, results and comparisons in Python; threads, asyncio, errors, and the time of its import."""

import asyncio
import json
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from support import short_run
from support.few import few
from support.paths import ROOT

import luxloop
from luxloop.scenarios.cli import main
from luxloop.scenarios.run import device
from luxloop.tracker.tracker import Tracker

HEAVY = {"numpy", "pandas", "numba", "scipy", "pydantic", "rich", "typer", "matplotlib", "rerun", "libsumo"}
IMPORT_MAX_S = 0.2


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """A current folder with one scenario."""
    monkeypatch.chdir(tmp_path)
    short_run.write(tmp_path)
    return tmp_path


def names_in(folder):
    return sorted(path.name for path in folder.iterdir())


class Blind:
    """Reports nothing."""

    def __init__(self, config):
        self.config = config

    def step(self, _scan):
        return luxloop.Tracks.from_boxes(np.empty(0, int), np.empty((0, 2)), 0.0, np.array([4.6, 1.8]))


def test_the_import_is_fast_and_loads_no_heavy_package():
    code = f"import sys, luxloop; dir(luxloop); print(sorted({HEAVY!r} & sys.modules.keys()))"
    done = subprocess.run([sys.executable, "-X", "importtime", "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
    (micros,) = re.findall(r"^import time: +\d+ \| +(\d+) \| luxloop$", done.stderr, re.MULTILINE)
    assert int(micros) < IMPORT_MAX_S * 1e6


def test_every_name_is_there_and_no_other():
    assert set(luxloop.__all__) <= set(dir(luxloop))
    for name in luxloop.__all__:
        assert getattr(luxloop, name) is not None
    with pytest.raises(AttributeError, match="module 'luxloop' has no attribute 'rnu'"):
        luxloop.rnu  # noqa: B018
    assert luxloop.Tracker is Tracker


@pytest.mark.usefixtures("folder")
def test_a_run_with_scans_can_be_graded_again_with_another_tracker():
    made = luxloop.run("short.toml", out="made", record_scans=True)
    again = luxloop.grade("made")
    assert again.metrics["track.hota"] == made.metrics["track.hota"]
    assert luxloop.grade("made", tracker=f"{__file__}:Blind").metrics["track.missed_share"].value == 1.0


@pytest.mark.parametrize("ahead", [False, True])
def test_a_run_is_that_of_the_run_loop_and_writes_nothing(folder, ahead, capfd):
    for scenario in ("short.toml", Path("short.toml"), luxloop.load_scenario("short.toml")):
        result = luxloop.run(scenario, ahead=ahead)
        assert result.trace_hash == short_run.result().trace_hash
        assert (result.verdict, result.checks, result.out) == ("no limits", [], None)
    assert names_in(folder) == ["short.toml"]
    assert capfd.readouterr() == ("", "")


def test_arguments_replace_keys_also_those_of_a_loaded_scenario():
    settings = {"noise.ideal": True, "traffic.actor[0].x_m": np.float32(11.0), "tracker.mma.method": "imm"}
    named = luxloop.run("short.toml", seed=np.int64(7), duration_s=0.4, settings=settings)
    loaded = luxloop.load_scenario("short.toml", settings={"noise.ideal": True})
    again = luxloop.run(
        loaded, seed=7, duration_s=0.4, settings=[f"{key}={value}" for key, value in settings.items()][1:]
    )
    assert (named.seed, named.frames) == (7, 5)
    assert named.config["set"] == ["noise.ideal=true", "traffic.actor[0].x_m=11.0", "tracker.mma.method=imm"]
    assert again.config == named.config
    assert again.trace_hash == named.trace_hash
    assert loaded.seed == 4


def test_figures_of_known_failures_hold_for_the_scenario_as_it_is_written_only():
    limit = '"track.hota" = { min = 2.0, known_failure = "0.99: HOTA is at most 1" }'
    short_run.write(Path(), f"{short_run.TEXT}\n[expect]\n{limit}\n")
    scenario = luxloop.load_scenario("short.toml")
    for same in (scenario, scenario.with_keys({}), scenario.with_keys({"seed": 4})):
        assert same.expect["track.hota"].known_failure.startswith("0.99: ")
    changed = scenario.with_keys({"seed": 5})
    assert changed.expect["track.hota"].known_failure == "HOTA is at most 1"
    assert changed.with_keys({"seed": 5}).expect["track.hota"].known_failure == "HOTA is at most 1"


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (True, "true"),
        (3, "3"),
        (0.1, "0.1"),
        ("imm", "imm"),
        ("true", '"true"'),
        ('a "b"\n', 'a "b"\n'),
        ([1, "x"], '[1, "x"]'),
        ({"min": 0.5, "need": "é"}, '{"min" = 0.5, "need" = "é"}'),
        (Path("nets/a.net.xml"), "nets/a.net.xml"),
    ],
)
def test_settings_of_every_type_are_read_back_as_given(value, text):
    from luxloop.scenarios.files import settings

    assert settings.texts({"a.b": value}) == [f"a.b={text}"]
    assert settings.parse(f"a.b={text}") == (["a", "b"], settings.plain(value))


@pytest.mark.parametrize("value", [None, float("nan"), object(), [None], np.zeros(2)])
def test_a_setting_without_a_form_in_toml_is_one_line(value):
    with pytest.raises(luxloop.Error, match=r"--set noise\.ideal: .* cannot be written in a scenario file; give "):
        luxloop.load_scenario("short.toml", settings={"noise.ideal": value})


def test_a_tracker_is_a_class_a_function_or_a_text(folder):
    (folder / "mine.py").write_text("from luxloop.tracker.tracker import Tracker\nclass Mine(Tracker): ...\n")
    made = []

    def make(config):
        made.append(Blind(config))
        return made[-1]

    by_class, by_function = luxloop.run("short.toml", tracker=Blind), luxloop.run("short.toml", tracker=make)
    assert by_class.metrics["track.hota"].value == by_function.metrics["track.hota"].value == 0.0
    assert by_class.config["device"] == f"{__name__}:Blind"
    assert len(made) == 2
    by_text = luxloop.run("short.toml", tracker="mine.py:Mine")
    by_name = luxloop.run("short.toml", tracker=luxloop.Tracker)
    assert by_text.trace_hash == by_name.trace_hash == short_run.result().trace_hash
    assert by_name.config["device"] == device.SHIPPED


class Seeing(Blind):
    def see_truth(self, *truth):
        raise AssertionError(truth)


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("make", [Seeing, lambda config: Seeing(config)])
def test_no_method_name_gives_a_tracker_the_truth_and_its_process_is_stated(make):
    """A class in the process of the run could find the truth; so its result says so, and is not compared."""
    result = luxloop.run("short.toml", tracker=make)
    assert result.config["in_process"]
    with pytest.raises(luxloop.Error, match="its tracker ran in the process of the truth"):
        luxloop.compare(short_run.result(), result)
    assert "in_process" not in luxloop.run("short.toml").config


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"scenario": "truck-shadw"}, "truck-shadw: no such scenario; did you mean truck-shadow"),
        ({"seed": "3"}, "short.toml: seed = "),
        ({"settings": {"noise.rane": 1}}, "short.toml: noise.rane = 1"),
        ({"tracker": Blind(None)}, "tracker: a Blind cannot be called; give a class or a function"),
        ({"tracker": "nowhere:Tracker"}, "--tracker nowhere:Tracker: no module nowhere"),
        ({"tracker": Blind, "oracles": ["fit"]}, "oracles replace stages of the shipped tracker, not of .*Blind"),
        ({"oracles": ["fits"]}, "oracles: fits: no such stage; give some of segmentation, outliers, fit,"),
        ({"record": True}, "need the folder of a run; give out or into"),
        ({"out": "a", "into": "b"}, "out and into are both given; omit one"),
        ({"tracker": lambda _: 1 / 0}, "ZeroDivisionError"),
    ],
)
def test_an_error_is_one_line_and_writes_nothing(arguments, message, folder):
    with pytest.raises(luxloop.Error, match=message) as error:
        luxloop.run(**{"scenario": "short.toml", **arguments})
    assert "\n" not in str(error.value)
    assert names_in(folder) == ["short.toml"]


def test_errors_of_rigs_and_traffic_are_luxloop_errors_too():
    from luxloop.sensor_model.rig.rig import load_rig
    from luxloop.sim.source import SimulatorFailedError

    with pytest.raises(luxloop.Error, match="no_such_rig"):
        load_rig("no_such_rig", Path())
    assert issubclass(SimulatorFailedError, luxloop.Error)


def test_a_folder_reads_back_as_the_result_and_has_the_default_name():
    result = luxloop.run("short.toml", into="runs", tracker=Blind, settings={"noise.ideal": True})
    assert result.out == Path("runs/short-seed4-Blind-noise.ideal=true")
    assert names_in(result.out) == ["report.txt", "result.json", "tables"]
    back = luxloop.load_result(result.out)
    assert (back.metrics, back.verdict, back.out) == (result.metrics, result.verdict, result.out)
    assert back.report() == result.report() == (result.out / "report.txt").read_text(encoding="utf-8")
    for name, table in result.tables.items():
        pd.testing.assert_frame_equal(back.tables[name], table, check_dtype=False, check_categorical=False)


def test_a_result_in_memory_can_be_saved_as_the_command_line_saves_it():
    result = luxloop.run("short.toml")
    saved = result.save("saved")
    assert saved.out == Path("saved")
    assert main(["run", "short.toml", "--no-recording", "--out", "ran", "-q"]) == 0
    documents = [json.loads(Path(name, "result.json").read_text()) for name in ("saved", "ran")]
    for document in documents:
        document["metrics"] = {k: v for k, v in document["metrics"].items() if not k.startswith("perf.")}
    assert documents[0] == documents[1]
    Path("saved", "mine.txt").write_text("mine")
    with pytest.raises(luxloop.Error, match="saved: holds other files than those of a run"):
        result.save("saved")


def test_a_comparison_of_results_is_that_of_their_folders():
    base = [luxloop.run("short.toml", seed=seed, into="base") for seed in (1, 2)]
    blind = f"{Path(__file__)}:Blind"
    head = [luxloop.run("short.toml", seed=seed, tracker=blind, out=f"head/{seed}") for seed in (1, 2)]
    of_folders = luxloop.compare("base", "head")
    assert of_folders.verdict == "worse"
    for comparison in (
        luxloop.compare(base, head),
        luxloop.compare("base", [result.out for result in head]),
        luxloop.compare([luxloop.load_result(run.out) for run in base], iter(head)),
    ):
        assert comparison.report() == of_folders.report()
    assert luxloop.compare(base[0], base[0]).verdict == "same"
    assert "WORSE" in of_folders.report()
    assert "track.hota" in text_of(of_folders._repr_html_().replace("<wbr>", ""))  # where a phone breaks the line
    with pytest.raises(luxloop.Error, match="BASE and HEAD: nothing to compare"):
        luxloop.compare(base[0], head[1])
    with pytest.raises(luxloop.Error, match="BASE: two runs of short seed 1"):
        luxloop.compare([base[0], base[0]], head)


def test_the_scenarios_are_listed_as_by_the_command_line(capfd):
    assert main(["list", "truck", "--family", "occlusion", "--json"]) == 0
    documents = json.loads(capfd.readouterr().out)
    entries = luxloop.list_scenarios("truck", family="occlusion")
    assert [entry.name for entry in entries] == [document["name"] for document in documents]
    assert luxloop.load_scenario(entries[0].name).description == entries[0].description
    with pytest.raises(luxloop.Error, match="no such family; give one of adversary"):
        luxloop.list_scenarios(family="urbn")


class Text(HTMLParser):
    """Texts and tags of a page."""

    def __init__(self):
        super().__init__()
        self.texts, self.tags = [], set()

    def handle_starttag(self, tag, _attributes):
        self.tags.add(tag)

    def handle_data(self, data):
        self.texts.append(data)


def parsed(html):
    text = Text()
    text.feed(html)
    return text


def text_of(html):
    return "\n".join(parsed(html).texts)


def test_a_notebook_shows_verdict_unmet_limits_and_main_metrics_and_no_markup_of_users():
    limits = (
        '"track.hota" = { min = 2.0, known_failure = "0.1: <script>alert(1)</script> & [/x]" }',
        '"track.missed" = { min = 9999, need = "<b>many</b>" }',
        '"track.false" = { max = 9999 }',
    )
    short_run.write(Path(), short_run.TEXT + "[expect]\n" + "\n".join(limits), "<i>short")
    shown = parsed(luxloop.run("<i>short.toml")._repr_html_().replace("<wbr>", ""))
    assert shown.tags == {"div", "p", "b", "br", "span", "table", "caption", "thead", "tbody", "tr", "th", "td"}
    text = "\n".join(shown.texts)
    assert "FAILED: 1 of 3 expectations hold, 1 failed, 1 known failure" in text
    assert "known failure\n0.1: <script>alert(1)</script> & [/x]" in re.sub("\n+", "\n", text)
    assert "failed\n<b>many</b>" in re.sub("\n+", "\n", text)
    assert "<i>short, seed 4, 10 frames" in text
    metrics = [cell for cell in shown.texts if re.fullmatch(r"[a-z]+\.[a-z][\w.]+", cell)]
    assert metrics[:3] == ["track.missed", "track.hota", "track.idf1"]  # failures first, then known failures
    assert "track.id_switches" in metrics


@pytest.mark.parametrize("ahead", few([False, True], True))
def test_runs_in_threads_at_once_and_beside_an_asyncio_loop(ahead):
    with ThreadPoolExecutor(2) as pool:
        results = list(pool.map(lambda _: luxloop.run("short.toml", ahead=ahead), range(2)))

    async def in_the_loop():
        beside = asyncio.create_task(asyncio.sleep(0.0, "done"))
        inside = luxloop.run("short.toml", ahead=ahead)  # as in a cell of a notebook
        return [inside, await asyncio.to_thread(luxloop.run, "short.toml", ahead=ahead)], await beside

    more, beside = asyncio.run(in_the_loop())
    assert beside == "done"
    assert {result.trace_hash for result in results + more} == {short_run.result().trace_hash}


SCRIPT = """\
import luxloop

class Mine(luxloop.Tracker):
    def step(self, scan):
        print("printed by the tracker")
        return super().step(scan)

result = luxloop.run("short.toml", tracker=Mine, ahead=True)
print(result.config["device"], result.trace_hash)
"""


@pytest.mark.slow
def test_a_script_without_a_guard_runs_its_own_class_beside_a_worker_process(folder):
    (folder / "script.py").write_text(SCRIPT)
    done = subprocess.run([sys.executable, "script.py"], capture_output=True, text=True, check=True)
    *printed, last = done.stdout.splitlines()
    assert last == f"__main__:Mine {short_run.result().trace_hash}"
    assert set(printed) == {"printed by the tracker"}
    assert done.stderr == ""
    assert names_in(folder) == ["script.py", "short.toml"]


USER = """\
from typing import reveal_type
import luxloop

def make(config: luxloop.TrackerConfig) -> luxloop.Tracker:
    return luxloop.Tracker(config)

result = luxloop.run("ring", tracker=make, seed=3, settings={"noise.ideal": True})
reveal_type(result)
reveal_type(result.metrics["track.hota"].value)
reveal_type(result.report())
reveal_type(luxloop.compare("runs", [result]))
reveal_type(luxloop.list_scenarios()[0].name)
reveal_type(luxloop.load_scenario("ring"))
luxloop.run("ring", tracker=3)
luxloop.rnu("ring")
"""


@pytest.mark.slow
def test_a_type_checker_knows_the_types(folder):
    (folder / "user.py").write_text(USER)
    command = [sys.executable, "-m", "mypy", "--strict", "--no-pretty", str(folder / "user.py")]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert re.findall(r'Revealed type is "([^"]+)"', done.stdout) == [
        "luxloop.scenarios.result.Result",
        "float | None",
        "str",
        "luxloop.scenarios.compare.comparison.Comparison",
        "str",
        "luxloop.scenarios.files.scenario.Scenario",
    ]
    errors = re.findall(r"user\.py:(\d+): error: .*\[(\S+)\]", done.stdout)
    assert errors == [("14", "arg-type"), ("15", "attr-defined")], done.stdout
