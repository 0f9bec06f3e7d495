"""`luxloop trends`: values by hand, gaps, changed scenarios, the page in a browser, and bad input."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support import browser
from support.paths import ROOT

from luxloop.scenarios.cli import main
from luxloop.scenarios.compare import baseline_file
from luxloop.scenarios.compare.run_pairs import Side
from luxloop.scenarios.compare.trends import KEY_METRICS, labels, small_line, trends, trends_document
from luxloop.scenarios.compare.vehicle_sums import SUMS
from luxloop.scenarios.document import html
from luxloop.scenarios.errors import InputError

CATALOG = ROOT / "scenarios" / "baseline" / "catalog.jsonl"
NAMED = ("overtake", "pitch", "ring")
FIT = [metric.name for metric in KEY_METRICS].index("fit.heading_abs_mean_deg")


def scaled(run, factor):
    sums = run.vehicles.sums.copy()
    sums[:, SUMS.index("fit_heading_deg")] *= factor
    return replace(run, trace_hash=f"times {factor}", vehicles=replace(run.vehicles, sums=sums))


def side(name, runs):
    return Side(Path(name), {run.key: run for run in runs}, [])


@pytest.fixture(scope="module")
def runs():
    """Twelve runs of the catalog; a comparison of all takes seconds."""
    every = baseline_file.read(CATALOG)
    named = [run for run in every if run.key.scenario in NAMED]
    return [*named, *(run for run in every if run not in named)][:12]


@pytest.fixture(scope="module")
def found(runs):
    """Three baselines: the second 10 % worse and without `pitch`, the third as the first with another `ring`."""
    second = [scaled(run, 1.1) for run in runs if run.key.scenario != "pitch"]
    third = [
        replace(run, sections=run.sections | {"noise": "other"}) if run.key.scenario == "ring" else run for run in runs
    ]
    return trends([side("v1.jsonl", runs), side("v2.jsonl", second), side("v3.jsonl", third)])


def test_suite_values_are_those_of_the_runs_that_all_baselines_have(runs, found):
    assert len(found.common) == len(runs) - 1
    kept = [run.vehicles.sums for run in runs if run.key.scenario != "pitch"]
    total = np.vstack(kept).sum(axis=0)
    expected = total[SUMS.index("fit_heading_deg")] / total[SUMS.index("fitted")]
    assert found.suite[:, FIT] == pytest.approx([expected, 1.1 * expected, expected])
    assert found.labels == ["v1", "v2", "v3"]


def test_each_scenario_has_its_values_and_gaps(found):
    pitch = found.scenarios["pitch"][:, FIT]
    assert np.isfinite(pitch).tolist() == [True, False, True]
    overtake = found.scenarios["overtake"][:, FIT]
    assert overtake[1] / overtake[0] == pytest.approx(1.1)
    assert found.changed == {"ring": [2]}


def test_verdicts_are_those_against_the_baseline_before(found):
    verdicts = [of.get("fit.heading_abs_mean_deg") for of in found.verdicts]
    assert verdicts == [None, "worse", "better"]


def test_run_that_ends_early_is_no_common_run(runs):
    late = [replace(runs[0], ended_early="the ego arrived"), *runs[1:]]
    assert runs[0].key not in trends([side("a", runs), side("b", late)]).common


def test_small_line_breaks_at_gaps_and_changed_scenarios():
    line = str(small_line(np.array([0.5, 0.6, np.nan, 0.7, 0.8, 0.9]), [4], KEY_METRICS[0], "a <line>"))
    assert [len(points.split()) for points in re.findall(r'points="([^"]*)"', line)] == [2, 2]
    assert line.count('class="new"') == 1
    assert "a &lt;line&gt;" in line
    empty = str(small_line(np.full(3, np.nan), [], KEY_METRICS[0], "nothing"))
    assert "polyline" not in empty
    assert "circle" not in empty


def test_constant_values_are_drawn_inside_the_line():
    line = str(small_line(np.zeros(3), [], KEY_METRICS[3], "no misses"))
    heights = [float(point.split(",")[1]) for point in re.search(r'points="([^"]*)"', line)[1].split()]
    assert len(set(heights)) == 1
    assert 0.0 < heights[0] < 24.0


def test_labels_are_the_shortest_different_ends_of_the_paths():
    assert labels([Path("a/one.jsonl"), Path("b/two")]) == ["one", "two"]
    assert labels([Path("a/catalog.jsonl"), Path("b/catalog.jsonl")]) == ["a/catalog", "b/catalog"]
    assert labels([Path("same.jsonl"), Path("same.jsonl")]) == ["1: same", "2: same"]


@pytest.mark.slow
def test_page_at_1280_pixels_and_on_a_phone(found, tmp_path):
    page = tmp_path / "trends.html"
    page.write_text(html.page(trends_document(found)), encoding="utf-8")
    with browser.started() as chromium:
        with browser.opened(chromium, page, viewport={"width": 1280, "height": 900}) as shown:
            assert browser.cut_off(shown) == []
            assert shown.locator("figure svg").count() == len(KEY_METRICS)
            assert shown.locator("svg.small").count() == len(found.scenarios) * len(KEY_METRICS)
            assert "ring in v3" in shown.locator("#changed").inner_text()
            assert "worse" in shown.locator("#suite table").inner_text()
            header = shown.locator("header").inner_text()
            assert re.search(r"HOTA is unchanged, from 0\.\d{3} in v1", header)
            assert shown.recorded == []
        with browser.opened(chromium, page, viewport={"width": 390, "height": 844}) as shown:
            assert shown.evaluate("document.documentElement.scrollWidth") <= 390


@pytest.mark.slow
def test_command_writes_the_page_and_prints_the_table(runs, tmp_path, capsys):
    for name, factor in (("one", 1.0), ("two", 1.1)):
        baseline_file.write(tmp_path / f"{name}.jsonl", [scaled(run, factor) for run in runs])
    out = tmp_path / "deep" / "page.html"
    code = main(["trends", str(tmp_path / "one.jsonl"), str(tmp_path / "two.jsonl"), "--out", str(out)])
    shown = capsys.readouterr().out
    assert code == 0
    assert re.search(r"^two .* 1\.\d{4} worse", shown, re.MULTILINE)
    assert shown.endswith(f"The page is {out}\n")
    assert "<title>Trends over 2 baselines</title>" in out.read_text(encoding="utf-8")


def test_bad_input_is_one_line(runs, tmp_path, capsys):
    baseline_file.write(tmp_path / "one.jsonl", runs[:1])
    baseline_file.write(tmp_path / "two.jsonl", runs[1:])
    one, two, page = (str(tmp_path / name) for name in ("one.jsonl", "two.jsonl", "page.html"))
    for arguments, message in (
        ([one], "one.jsonl: the only baseline; give at least two"),
        ([one, two], "no complete run is in all baselines"),
        ([one, str(tmp_path / "three.jsonl")], "three.jsonl: No such file"),
    ):
        assert main(["trends", *arguments, "--out", page]) == 2
        out, err = capsys.readouterr()
        assert (out, err.count("\n")) == ("", 1)
        assert message in err
    assert not Path(page).exists()


def test_no_runs_is_an_error():
    with pytest.raises(InputError, match="the only baseline"):
        trends([side("a", [])])
