"""Blame: a fault planted into a stage is attributed to this stage by the metrics that should detect it."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
from support import busy_street, faulty_stages, short_run
from support.few import few
from support.paths import ROOT

from luxloop.scenarios.cli import main
from luxloop.scenarios.compare.stage_costs import OWN_DRIVES, answer, blame_report, stage_costs
from luxloop.scenarios.metrics.definitions import find_metric, is_metric
from luxloop.scenarios.oracle.oracle_tracker import OracleFactory
from luxloop.scenarios.oracle.stage import Stage
from luxloop.scenarios.oracle.stage_blame import BLAME_METRICS, StageCost, find_out
from luxloop.scenarios.report import text as report
from luxloop.scenarios.run import device, loop
from luxloop.sim.scripted.scripted_source import ScriptedSource
from luxloop.sim.source import TrafficEndedError

FAULTS = {
    Stage.SEGMENTATION: (faulty_stages.CoarseSegmentation, ["segmentation.under_rate", "track.hota", "track.missed"]),
    Stage.OUTLIERS: (
        faulty_stages.RemovingNothing,
        ["outliers.recall{cause=mirror}", "outliers.recall{cause=layer_overlap}"],
    ),
    Stage.FIT: (faulty_stages.BiasedFit, ["fit.heading_abs_mean_deg", "track.hota"]),
    Stage.ASSOCIATION: (faulty_stages.ScrambledAssociation, ["track.idf1", "track.hota", "track.false"]),
    Stage.MODEL: (faulty_stages.AlwaysAccelerating, ["mma.mode_accuracy"]),
    Stage.SIZE: (faulty_stages.LongSizes, ["track.length_abs_mean_m", "track.hota"]),
    Stage.CONFIRMATION: (faulty_stages.SlowConfirmation, ["track.time_to_confirm_s", "track.missed", "track.hota"]),
}


SCENES = {
    # The overlap of a car beside the ego is bows just over 0.2 m deep, which T-linkage keeps; that of a car behind is
    # mostly deeper.
    Stage.OUTLIERS: busy_street.TEXT.replace("x_m = 8\n", "x_m = -16\n"),
    # A merged pair gives boxes that fit neither car, which segmentation's truth would remove from the false tracks, and
    # whose overlap suffers as much as that of turned boxes.
    Stage.SEGMENTATION: busy_street.APART,
    Stage.FIT: busy_street.APART,
    Stage.ASSOCIATION: busy_street.APART,
    Stage.SIZE: busy_street.APART,
    # A merged pair that is confirmed at once hits neither car.
    Stage.CONFIRMATION: busy_street.APART,
}
"""Streets in which the sound stage, or the one before it, makes few errors, so that the fault stands out."""


@pytest.mark.parametrize("stage", few(Stage, Stage.FIT))
def test_a_planted_fault_is_blamed_on_its_stage(stage):
    """The fault changes its metrics, and no other oracle compensates half as much of it."""
    fault, caught_by = FAULTS[stage]
    text = SCENES.get(stage, busy_street.TEXT)
    faulty = find_out(busy_street.scenario(text), faulty_stages.plant(fault))
    healthy = busy_street.blamed(text)
    for name in caught_by:
        first, *others = faulty.ranking(name)
        assert first == stage, name
        gain = faulty.gain(stage, name)
        assert gain > 2 * (healthy.gain(stage, name) or 0.0), name
        assert all(faulty.gain(other, name) < 0.5 * gain for other in others), name


def test_parallel_oracles_give_the_results_of_separate_runs():
    """All process the same scans without affecting each other."""
    stage = Stage.ASSOCIATION
    separate = loop.run(busy_street.scenario(), OracleFactory([stage]))
    parallel = busy_street.blamed().by_truth[stage]
    for metric in BLAME_METRICS:
        assert parallel[metric] == separate.metrics[metric]


def test_every_blame_metric_is_a_metric_with_a_direction():
    assert all(is_metric(metric) for metric in BLAME_METRICS)
    found = busy_street.blamed()
    for metric in BLAME_METRICS:
        ranking = found.ranking(metric)
        gains = [found.gain(stage, metric) for stage in ranking]
        assert gains == sorted(gains, reverse=True)
        assert all(gain > 0 for gain in gains)
        if ranking:
            as_is, best = (of[metric].value for of in (found.shipped.metrics, found.by_truth[ranking[0]]))
            assert (best < as_is) == (find_metric(metric).definition.better == "less")


def test_the_report_has_a_row_for_each_stage_and_a_sentence_for_each_metric():
    text = report.as_text(blame_report(busy_street.blamed(), stage_costs(busy_street.blamed())))
    assert max(map(len, text.splitlines())) <= report.WIDTH
    assert "…" not in text  # no column is too narrow for its title
    first, *lines = text.splitlines()
    assert " costs " in first
    for row, tables in {"none": 3, **dict.fromkeys(Stage, 4)}.items():
        assert sum(line.startswith(f"{row} ") for line in lines) == tables, row
    found, name = busy_street.blamed(), "fit.position_abs_mean_m"
    first, second = found.ranking(name)[:2]
    results = (found.shipped.metrics, found.by_truth[first], found.by_truth[second])
    shown = [f"{metrics[name].value:.3f}" for metrics in results]
    assert f"{name} is {shown[0]}: {first} ({shown[1]}) costs most, then {second} ({shown[2]})" in text
    heading = found.shipped.metrics["fit.heading_abs_mean_deg"].value
    assert f"fit.heading_abs_mean_deg is {heading:.3f}: fit (0.000) costs most" in text
    assert "track.false_on_nothing is 0: no stage's truth makes it better" in text
    assert OWN_DRIVES not in text


def test_the_answer_is_the_largest_cost_with_its_interval():
    found = busy_street.blamed()
    costs = stage_costs(found)
    assert [cost.value for cost in costs] == sorted((cost.value for cost in costs), reverse=True)
    assert {cost.stage: cost.value for cost in costs} == {s: found.gain(s, "track.hota") for s in Stage}
    for cost in costs:
        low, high = cost.interval or (-1.0, 1.0)
        assert low - 5e-4 <= cost.value <= high + 5e-4  # the value is rounded
    first, *lines = filter(None, map(str.strip, report.as_text(blame_report(found, costs)).splitlines()))
    assert first.startswith(f"{costs[0].stage} costs {costs[0].value:.3f} HOTA")
    assert "most of all stages" in first
    assert "Cost in HOTA" in lines


COST = StageCost(Stage.FIT, 0.046, (0.02, 0.07))


@pytest.mark.parametrize(
    ("costs", "line"),
    [
        ([COST], "fit costs 0.046 HOTA [0.020, 0.070], most of all stages"),
        ([replace(COST, interval=(-0.02, 0.1))], "most of all stages, which may be chance"),
        ([replace(COST, interval=None)], "most of all stages; no interval: too few vehicles, or a drive for each"),
        ([replace(COST, value=0.0)], "No stage costs HOTA: the truth in the place of none of them improves its"),
    ],
)
def test_the_answer_says_how_sure_it_is(costs, line):
    assert line in answer(busy_street.blamed(), costs)


@pytest.mark.slow
def test_two_vehicles_have_no_interval_beyond_the_range_of_hota():
    """The jackknife of two vehicles reaches beyond 1."""
    found = find_out(busy_street.scenario(short_run.TEXT))
    for cost in stage_costs(found):
        assert cost.interval is None or -1.0 <= cost.interval[0] <= cost.interval[1] <= 1.0


def test_json_output_contains_all_values_and_nothing_else(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    short_run.write(Path())
    assert main(["blame", "short.toml", "--json", "--seed", "9", "--duration", "0.4"]) == 0
    out, err = capfd.readouterr()
    assert err == ""
    found = json.loads(out)
    assert (found["scenario"], found["seed"], found["complete"], found["frames"]) == ("short", 9, True, 5)
    assert list(found["by_truth"]) == [str(stage) for stage in Stage]
    assert found["by_truth"]["fit"]["fit.heading_abs_mean_deg"]["value"] < 1e-6
    assert found["ranking"]["fit.heading_abs_mean_deg"][0] == "fit"
    assert found["shipped"]["outliers.recall{cause=mirror}"]["reason"]
    assert set(found["costs"]["track.hota"]) == set(Stage)
    assert sorted(path.name for path in Path().iterdir()) == ["short.toml"]


@pytest.mark.parametrize(
    ("text", "arguments", "error"),
    [
        (short_run.TEXT, ["--tracker", "mine:Tracker"], "no module mine on the Python path"),
        (short_run.TEXT + '[tracker.mma]\nmethod = "imm"\n', [], 'oracle model: [tracker.mma] method = "imm"'),
    ],
)
def test_invalid_options_give_one_error_line(text, arguments, error, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    short_run.write(Path(), text)
    assert main(["blame", "short.toml", *arguments]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert error in err


@pytest.mark.slow
def test_closed_loop_control_has_a_drive_for_every_oracle(capfd):
    assert main(["blame", "cruise-on-tracks", "--duration", "0.16"]) == 0
    out = capfd.readouterr().out
    assert "seed 1, 2 frames" in out
    assert OWN_DRIVES in out


def test_values_of_a_run_that_ended_early_are_marked(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    short_run.write(Path())

    class Breaking(ScriptedSource):
        played = 0

        def step(self):
            self.played += 1
            if self.played > 2:
                raise TrafficEndedError("the ego left")
            return super().step()

    monkeypatch.setattr("luxloop.sim.scripted.scripted_source.ScriptedSource", Breaking)
    assert main(["blame", "short.toml", "--json"]) == 1
    out, err = capfd.readouterr()
    assert json.loads(out)["ended_early"] == "the ego left"
    assert "the figures are of the 2 frames until then" in err


EXAMPLE = str(ROOT / "docs" / "examples" / "distance_score.py")


@pytest.mark.slow
def test_a_tracker_with_an_association_of_its_own_is_blamed(tmp_path, capsys):
    """Its own association remains beneath the oracles of the other stages, and the truth replaces it."""
    path = short_run.write(tmp_path, busy_street.TEXT)
    assert main(["blame", str(path), "--tracker", f"{EXAMPLE}:tracker", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["tracker"].endswith("distance_score.py:tracker")
    alone = loop.run(busy_street.scenario(), device.load(f"{EXAMPLE}:tracker"))
    assert found["trace_hash"] == alone.trace_hash != busy_street.blamed().shipped.trace_hash
    shipped = busy_street.blamed().by_truth[Stage.ASSOCIATION]
    assert found["by_truth"]["association"]["track.hota"]["value"] == pytest.approx(
        shipped["track.hota"].value, abs=0.05
    )


STAGES = """
from luxloop.tracker.detection.detector import Detector
from luxloop.tracker.records import Tracks
from luxloop.tracker.tracker import Tracker

class Boxes:
    def __init__(self, config): self.real = Detector(config)
    def check(self, scan): self.real.check(scan)
    def step(self, scan, movers=None, long=None): return self.real.step(scan, movers, long)

class Nothing:
    def __init__(self, config): ...
    def step(self, scan): return Tracks.from_boxes([], [], [], [])

class Pairs:
    def associate(self, *_): return []

def boxes(config): return Tracker(config, Boxes(config))
def pairs(config): return Tracker(config, associator=Pairs())
"""


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("boxes", "its detector has no segment, link, fit and box, which oracles replace; derive it from"),
        ("pairs", "its associator has no pair score, which oracles replace; derive it from"),
        ("Nothing", "has none of the stages detector, associator, track_management that oracles"),
    ],
)
def test_a_tracker_without_a_stage_is_one_line_that_names_it(name, message, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    path = short_run.write(tmp_path, short_run.TEXT)
    Path("mine.py").write_text(STAGES, encoding="utf-8")
    assert main(["blame", str(path), "--tracker", f"mine.py:{name}"]) == 2
    error = capfd.readouterr().err
    assert error.startswith(f"luxloop: error: mine.py:{name}: {message}")
    assert error.count("\n") == 1


def test_another_process_has_no_stages(tmp_path, capfd):
    path = short_run.write(tmp_path, short_run.TEXT)
    assert main(["blame", str(path), "--tracker", "process:true"]) == 2
    assert "oracles cannot replace the stages of another process" in capfd.readouterr().err
