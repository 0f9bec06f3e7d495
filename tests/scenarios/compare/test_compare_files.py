"""Folders of runs and baseline files: pairing, runs left out, and output and exit codes of the commands."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support import recorded, short_run
from support.paths import DOCS

from luxloop.scenarios.cli import main
from luxloop.scenarios.compare import baseline_file, run_pairs
from luxloop.scenarios.compare.compared_metrics import COMPARED_METRICS
from luxloop.scenarios.compare.run_pairs import pair
from luxloop.scenarios.compare.vehicle_sums import SUMS, TRUTH
from luxloop.scenarios.errors import InputError, OutputError
from luxloop.scenarios.files.expect import Limit, check
from luxloop.scenarios.result import Metric
from luxloop.scenarios.run import run_folder


def write(folder, result=None, **changes):
    """Write the short run into a folder, with changed fields."""
    result = replace(result or short_run.result(), **changes)
    limits = {name: Limit(**limit) for name, limit in result.config["expect"].items()}
    with run_folder.create(folder) as inside:
        run_folder.write(inside, result, check(result.metrics, limits), "report\n")
    return folder


def config(**changes):
    return {**short_run.result().config, **changes}


def run_command(capsys, *arguments):
    """Run a command; return its exit code, standard output and standard error."""
    code = main([str(argument) for argument in arguments])
    out, err = capsys.readouterr()
    return code, out, err


def one_line(text):
    """Undo the breaks of long lines."""
    return " ".join(text.split())


def edit(run, before, after):
    """Replace a part of a run's result, as another version would have written it."""
    text = (run / "result.json").read_text(encoding="utf-8")
    assert before in text
    (run / "result.json").write_text(text.replace(before, after), encoding="utf-8")


def pairs_of(base, head):
    return pair(run_pairs.read_side(base), run_pairs.read_side(head))


# --- reading


def test_folder_with_subfolders_and_single_run_are_read(tmp_path):
    for seed in (2, 1):
        write(tmp_path / "runs" / "family" / f"short-seed{seed}", seed=seed)
    (tmp_path / "runs" / "notes.txt").write_text("mine")
    assert [str(key) for key in run_pairs.read_side(tmp_path / "runs").runs] == ["short seed 1", "short seed 2"]
    assert len(run_pairs.read_side(tmp_path / "runs" / "family" / "short-seed2").runs) == 1


def test_unfinished_run_is_left_out_with_a_note(tmp_path):
    base, head = write(tmp_path / "base" / "a"), write(tmp_path / "head" / "a")
    head.parent.joinpath("a").rename(head.parent / ".b.host-1-00000000.partial")
    write(head)
    pairs = pairs_of(base.parent, head.parent)
    assert len(pairs.compared) == 1
    assert any("not finished: .b.host-1-00000000.partial" in note for note in pairs.notes)


def test_two_runs_of_one_scenario_and_seed_are_refused(tmp_path):
    write(tmp_path / "runs" / "a"), write(tmp_path / "runs" / "b")
    with pytest.raises(OutputError, match=r"two runs of short seed 4, .*a and .*b; keep one"):
        run_pairs.read_side(tmp_path / "runs")


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda run: (run / "tables" / "tracks.parquet").unlink(), "the run has no 'tracks'"),
        (lambda run: (run / "tables" / "tracks.parquet").write_bytes(b"PAR1 no"), "damaged"),
        (lambda run: edit(run, '"points_min": 10', '"points": 10'), "of another version of luxloop"),
        (lambda run: edit(run, '"expect": {}', '"limits": {}'), "the run has no 'expect'"),
        (lambda run: (run / "result.json").write_text("{"), "damaged"),
    ],
)
def test_damaged_run_gives_one_line(tmp_path, capsys, damage, message):
    run = write(tmp_path / "run")
    damage(run)
    code, out, err = run_command(capsys, "compare", run, run)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert str(run) in err
    assert message in err


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, "No such file or directory; give a folder of runs or a baseline file"),
        ("hello\n", "not a baseline file"),
        ('{"luxloop_baseline": 0, "sums": []}\n', "not a baseline file of this version"),
        (json.dumps(baseline_file.HEADER) + "\n", "no run in it"),
        (json.dumps(baseline_file.HEADER) + '\n{"scenario": "ring"}\n', "line 2 is not a run"),
        (json.dumps(baseline_file.HEADER) + "\n[1, 2]\n", "line 2 is not a run"),
        ("", "not a baseline file"),
        (json.dumps(baseline_file.HEADER) + '\n{"scenario": ["ring"], "seed": 1}\n', "line 2 is not a run"),
        (json.dumps(baseline_file.HEADER) + '\n{"scenario": "ring", "seed": "1"}\n', "line 2 is not a run"),
    ],
)
def test_invalid_baseline_file_gives_one_line(tmp_path, capsys, text, message):
    path = tmp_path / "baseline.jsonl"
    if text is not None:
        path.write_text(text)
    code, out, err = run_command(capsys, "compare", path, path)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert f"{path}: {message}" in err


def test_empty_folder_is_an_error(tmp_path, capsys):
    assert run_command(capsys, "compare", tmp_path, tmp_path)[0] == 2
    code, _, err = run_command(capsys, "baseline", tmp_path, "--out", tmp_path / "baseline.jsonl")
    assert code == 2
    assert "no run in it; give a folder" in err
    assert list(tmp_path.iterdir()) == []


# --- pairing


def test_runs_without_a_partner_are_named(tmp_path, capsys):
    for seed in (1, 2):
        write(tmp_path / "base" / str(seed), seed=seed)
    for seed in (2, 3):
        write(tmp_path / "head" / str(seed), seed=seed)
    code, out, _ = run_command(capsys, "compare", tmp_path / "base", tmp_path / "head")
    assert code == 0
    for line in ("1 pairs of runs compared", "Only in BASE: short seed 1", "Only in HEAD: short seed 3"):
        assert line in out


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"grading": {"points_min": 11}}, "grading differ"),
        ({"duration_s": 1.0, "noise": {}}, "duration_s, noise differ"),
    ],
)
def test_changed_scenario_is_not_compared(tmp_path, changes, reason):
    write(tmp_path / "base" / "a"), write(tmp_path / "base" / "b", seed=5)
    write(tmp_path / "head" / "a", config=config(**changes)), write(tmp_path / "head" / "b", seed=5)
    pairs = pairs_of(tmp_path / "base", tmp_path / "head")
    assert [str(key) for key in pairs.incomparable] == ["short seed 4"]
    assert reason in "".join(pairs.incomparable.values())
    assert len(pairs.compared) == 1


def test_comparison_without_pairs_is_bad_input(tmp_path, capsys):
    base, head = write(tmp_path / "base"), write(tmp_path / "head", config=config(duration_s=9.0))
    with pytest.raises(InputError, match=r"nothing to compare, short seed 4: the scenario has changed \(duration_s"):
        pairs_of(base, head)
    other = write(tmp_path / "other", seed=9)
    code, _, err = run_command(capsys, "compare", base, other)
    assert code == 2
    assert "no scenario was run with the same seed in both" in err


def test_prose_may_change_and_changes_under_test_are_noted(tmp_path):
    limits = {"track.hota": {"max": 0.0}}
    base = write(tmp_path / "base", config=config(description="x", reason="y", expect=limits))
    changes = {"device": "mine:Tracker", "expect": {"track.hota": {"max": 0.0, "need": "prose"}}, "reason": "z"}
    head = write(tmp_path / "head", config=config(**changes), versions={**short_run.result().versions, "numba": "0"})
    notes = "\n".join(pairs_of(base, head).notes)
    assert "The device under test differs in short seed 4" in notes
    assert "The [expect] table differs in short seed 4" in notes
    assert "tracker] table" not in notes
    assert "numba is" in notes


@pytest.mark.parametrize("looser", [pytest.param({"track.hota": {"max": 1.0}}, marks=pytest.mark.slow), {}])
def test_changed_limits_are_refused_until_the_baseline_is_made_anew(tmp_path, capsys, looser):
    strict = {"track.hota": {"max": 0.0}}
    run = write(tmp_path / "base" / "short", config=config(expect=strict)).parent
    for seed in (4, 5):
        head = write(tmp_path / "head" / str(seed), config=config(expect=looser), seed=seed).parent
    baseline = tmp_path / "baseline.jsonl"
    run_command(capsys, "baseline", run, "--out", baseline)
    for base in (run, baseline):
        code, out, err = run_command(capsys, "compare", base, head)
        assert (code, out, err.count("\n")) == (2, "", 1)
        now = "<= 1" if looser else "none"
        assert f"the limits of short seed 4 differ (track.hota: <= 0 in BASE, {now} in HEAD); run BASE again" in err
        assert f"luxloop baseline {head} --out FILE" in err
    run_command(capsys, "baseline", head, "--out", baseline)
    assert run_command(capsys, "compare", baseline, head)[0] == 0


def test_limits_of_times_may_differ(tmp_path, capsys):
    base = write(tmp_path / "base", config=config(expect={"perf.tracker_ms_p50": {"max": 40.0}}))
    head = write(tmp_path / "head", config=config(expect={"perf.tracker_ms_p50": {"max": 60.0}}))
    assert run_command(capsys, "compare", base, head)[0] == 0


def test_incomplete_run_is_not_compared_and_newly_incomplete_run_fails(tmp_path, capsys):
    for side in ("base", "head"):
        write(tmp_path / side / "whole")
        write(tmp_path / side / "always", seed=5, ended_early="the ego arrived")
        write(tmp_path / side / "newly", seed=6, ended_early="" if side == "base" else "the ego crashed")
    code, out, _ = run_command(capsys, "compare", tmp_path / "base", tmp_path / "head")
    assert code == 1
    assert "short seed 5: BASE ended early (the ego arrived) and HEAD ended early (the ego arrived)" in one_line(out)
    assert out.startswith("WORSE: HEAD is worse than BASE: 1 run newly ends early")
    assert "Newly incomplete short seed 6:" in " ".join(out.split())
    assert run_command(capsys, "compare", tmp_path / "head", tmp_path / "base")[0] == 0


def test_run_with_other_traffic_or_points_is_one_unit_with_a_note(tmp_path):
    truth = short_run.result().tables["truth"]
    moved = {**short_run.result().tables, "truth": truth.assign(points=truth["points"] + 1)}
    base, head = write(tmp_path / "base"), write(tmp_path / "head", tables=moved)
    pairs = pairs_of(base, head)
    assert "Traffic or points differ in short seed 4" in pairs.notes[0]
    assert [len(sums) for sums in pairs.compared[0].units()] == [1, 1]
    same = pairs_of(base, base)
    assert same.notes == []
    assert len(same.compared[0].units()[0]) == 3  # two vehicles and NO_ACTOR


def test_vehicles_with_the_same_truth_stay_units_beside_another_one(tmp_path):
    result = short_run.result()
    truth = result.tables["truth"]
    second = truth["actor_id"] == truth["actor_id"].max()
    moved = truth.assign(x_world_m=truth["x_world_m"] + 2e-6 * second)
    base, head = write(tmp_path / "base"), write(tmp_path / "head", tables={**result.tables, "truth": moved})
    pairs = pairs_of(base, head)
    assert "Traffic or points differ in short seed 4 (1 vehicles without a counterpart)" in pairs.notes[0]
    units = pairs.compared[0].units()[0]
    assert units.shape[0] == 2  # one vehicle; the other with the false tracks
    assert np.allclose(units.sum(axis=0), pairs_of(base, base).compared[0].units()[0].sum(axis=0))


def test_truth_means_do_not_depend_on_the_tracker(tmp_path):
    truth = short_run.result().tables["truth"]
    other = {**short_run.result().tables, "truth": truth.assign(track_id=-1, segments=0, largest_segment_share=0.0)}
    base, head = write(tmp_path / "base"), write(tmp_path / "head", tables=other)
    assert pairs_of(base, head).compared[0].same_truth


# --- baselines


def test_baseline_round_trip_and_equal_bytes_of_equal_runs(tmp_path):
    runs = list(recorded.base())
    baseline_file.write(tmp_path / "a.jsonl", runs)
    baseline_file.write(tmp_path / "b.jsonl", runs[::-1])
    assert (tmp_path / "a.jsonl").read_bytes() == (tmp_path / "b.jsonl").read_bytes()
    for back in baseline_file.read(tmp_path / "a.jsonl"):
        run = next(run for run in runs if run.key == back.key)
        for name in ("trace_hash", "ended_early", "device", "sections", "versions", "expectations"):
            assert getattr(back, name) == getattr(run, name)
        assert np.array_equal(back.vehicles.columns(), run.vehicles.columns())
        assert np.array_equal(back.vehicles.vehicle, run.vehicles.vehicle)
        assert np.array_equal(back.vehicles.truth, run.vehicles.truth)


def test_baseline_is_small_and_has_a_line_per_run_with_versions(tmp_path):
    runs = recorded.base()
    baseline_file.write(tmp_path / "baseline.jsonl", list(runs))
    lines = (tmp_path / "baseline.jsonl").read_text().splitlines()
    assert len(lines) == 1 + len(runs)
    assert json.loads(lines[1])["versions"]["numpy"]
    vehicles = sum(len(run.vehicles.vehicle) for run in runs)
    assert sum(map(len, lines)) < 1500 * len(runs) + 250 * vehicles  # 40 runs of 20 vehicles: 260 kB at most


def test_baseline_command_replaces_the_file_and_lists_new_changed_and_dropped_runs(tmp_path, capsys):
    out = tmp_path / "kept" / "baseline.jsonl"
    write(tmp_path / "before" / "1", seed=1), write(tmp_path / "before" / "2", seed=2)
    assert run_command(capsys, "baseline", tmp_path / "before", "--out", out)[0] == 0
    (
        write(tmp_path / "after" / "2", seed=2, trace_hash="ff"),
        write(tmp_path / "after" / "3", seed=3, ended_early="gone"),
    )
    code, said, _ = run_command(capsys, "baseline", tmp_path / "after", "--out", out)
    assert code == 0
    for line in ("1 new: short seed 3", "1 changed: short seed 2", "1 dropped: short seed 1", "1 ended early"):
        assert line in said
    assert [run.key.seed for run in baseline_file.read(out)] == [2, 3]
    assert [path.name for path in out.parent.iterdir()] == ["baseline.jsonl"]


def test_compare_writes_no_files(tmp_path, capsys):
    run = write(tmp_path / "run")
    run_command(capsys, "baseline", run, "--out", tmp_path / "baseline.jsonl")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    assert run_command(capsys, "compare", tmp_path / "baseline.jsonl", run)[0] == 0
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


def test_other_file_is_not_replaced_by_a_baseline(tmp_path, capsys):
    precious = tmp_path / "thesis.txt"
    precious.write_text("precious")
    assert run_command(capsys, "baseline", write(tmp_path / "run"), "--out", precious)[0] == 2
    assert precious.read_text() == "precious"


def test_baseline_does_not_depend_on_times(tmp_path):
    limits = {"perf.tracker_ms_p50": {"max": 40.0}, "track.idf1": {"min": 0.3}}
    for name, time_ms in (("fast", 1.0), ("slow", 60.0)):
        timed = {**short_run.result().metrics, "perf.tracker_ms_p50": Metric(time_ms, "ms", 10)}
        run = write(tmp_path / name, metrics=timed, config=config(expect=limits))
        baseline_file.write(tmp_path / f"{name}.jsonl", list(run_pairs.read_side(run).runs.values()))
    assert (tmp_path / "fast.jsonl").read_bytes() == (tmp_path / "slow.jsonl").read_bytes()
    assert "track.idf1" in (tmp_path / "fast.jsonl").read_text()


# --- end to end


BLIND = """\
from dataclasses import fields, replace
from luxloop.tracker.tracker import Tracker as Shipped


class Tracker(Shipped):
    def step(self, scan):
        tracks, trace = super().step(scan)
        empty = {f.name: getattr(tracks, f.name)[:0] for f in fields(tracks)
                 if f.name != "models" and getattr(tracks, f.name) is not None}
        return replace(tracks, **empty), trace
"""


@pytest.fixture(scope="module")
def real_runs(tmp_path_factory):
    """Runs of the command line: by the shipped tracker, and by a tracker without any reported tracks."""
    folder = tmp_path_factory.mktemp("real")
    expect = '[expect]\n"track.idf1" = { min = 0.3 }\n"track.hota" = { min = 2.0 }\n'
    scenario = short_run.write(folder, short_run.TEXT + expect)
    (folder / "blind.py").write_text(BLIND)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder)
        for name, tracker in {"base": "luxloop.tracker.tracker:Tracker", "head": "blind:Tracker"}.items():
            out = folder / name / "short"
            main(["run", str(scenario), "--out", str(out), "--no-recording", "--tracker", tracker])
    return folder


def test_identical_runs_are_identical_also_from_a_baseline(real_runs, tmp_path, capsys):
    run_command(capsys, "baseline", real_runs / "base", "--out", tmp_path / "b.jsonl")
    code, out, err = run_command(capsys, "compare", tmp_path / "b.jsonl", real_runs / "base")
    assert (code, err) == (0, "")
    assert "1 pairs of runs compared, 1 of them identical (same trace hash)" in out
    assert "SAME: HEAD is as good as BASE; no metric is worse" in out


def test_newly_failed_expectation_exits_with_1(real_runs, capsys):
    code, out, _ = run_command(capsys, "compare", real_runs / "base", real_runs / "head")
    assert code == 1
    assert "1 expectation newly fails" in " ".join(out.split())
    assert "still failing" in out
    code, out, _ = run_command(capsys, "compare", real_runs / "head", real_runs / "base")
    assert code == 0
    assert "mended" in out


def without_observations(run):
    """Write a run in which no vehicle was graded and no track reported."""
    tables = dict(short_run.result().tables)
    tables |= {name: tables[name][:0] for name in ("tracks", "overlaps", "fits", "segments")}
    tables["truth"] = tables["truth"].assign(graded=False, largest_segment_share=np.nan)
    return write(run, tables=tables)


def test_comparison_without_any_value_exits_with_5(tmp_path, capsys):
    run = without_observations(tmp_path / "run")
    code, out, _ = run_command(capsys, "compare", run, run)
    assert code == 5
    assert "CANNOT TELL: The runs cannot tell whether HEAD is worse: no metric has a value" in out


def fits_five_percent_worse(run, base):
    fits = short_run.result().tables["fits"]
    worse = fits.assign(heading_error_deg=1.05 * fits["heading_error_deg"])
    return write(run, tables={**short_run.result().tables, "fits": worse}), write(base)


def test_loss_that_few_vehicles_cannot_exclude_exits_with_5_and_a_larger_one_with_0(tmp_path, capsys):
    head, base = fits_five_percent_worse(tmp_path / "head", tmp_path / "base")
    code, out, _ = run_command(capsys, "compare", base, head)
    assert code == 5
    assert "CANNOT TELL: The runs cannot tell whether HEAD is worse" in out
    assert "a loss of 2 % is not excluded for fit.heading_abs_mean_deg" in " ".join(out.split())
    assert run_command(capsys, "compare", base, head, "--loss", "100")[0] == 0
    assert run_command(capsys, "compare", base, base)[0] == 0


@pytest.mark.parametrize("loss", ["-1", "101", "much", "nan"])
def test_loss_out_of_range_gives_one_line(tmp_path, capsys, loss):
    run = write(tmp_path / "run")
    code, out, err = run_command(capsys, "compare", run, run, f"--loss={loss}")
    assert (code, out) == (2, "")
    assert "--loss" in err


def test_json_output_is_complete(real_runs, capsys):
    code, out, err = run_command(capsys, "compare", real_runs / "base", real_runs / "head", "--json")
    document = json.loads(out)
    assert (code, err, out.count("\n")) == (1, "", 1)
    assert document["failed"] is True
    assert [fall["fate"] for fall in document["expectations"]] == ["newly failed", "still failing"]
    idf1 = document["metrics"]["track.idf1"]
    assert idf1["head"] == 0.0
    assert idf1["difference"] == pytest.approx(-idf1["base"])
    assert document["pairs"][0]["metrics"]["track.idf1"] == [idf1["base"], 0.0]
    assert document["metrics"]["track.occlusion_survival"]["base"] is None
    assert (document["pairs"][0]["identical"], document["pairs"][0]["same_truth"]) == (False, True)


def test_baseline_header_names_the_columns(tmp_path):
    baseline_file.write(tmp_path / "b.jsonl", list(recorded.base()))
    header = json.loads(Path(tmp_path / "b.jsonl").read_text().splitlines()[0])
    assert header == {"luxloop_baseline": baseline_file.FORMAT, "sums": ["vehicle", *SUMS], "truth": [*TRUTH]}


# --- the page


def test_page_lists_every_compared_metric_with_its_margin():
    page = (DOCS / "regression-tests.md").read_text(encoding="utf-8")
    listed = {}
    for names, better, margin in re.findall(r"^\| (`\w+\..*?) \| (more|less) \| (.*?) \|$", page, re.MULTILINE):
        listed |= dict.fromkeys(re.findall(r"`([^`]+)`", names), (better, margin))
    assert listed == {metric.name: (metric.better, margin_of(metric)) for metric in COMPARED_METRICS}


def margin_of(metric):
    relevance = metric.relevance
    if not relevance.relative:
        return f"{relevance.absolute:g}"
    return f"{relevance.relative:.0%}".replace("%", " %") + f", and {relevance.absolute:g} {metric.unit}"
