"""Curves of studies against means and intervals computed by hand, and the report page."""

import math
from html.parser import HTMLParser

import numpy as np
import pandas as pd
import pytest

from luxloop.scenarios.document.document import plain
from luxloop.scenarios.statistics.intervals import mid_p_interval
from luxloop.scenarios.study.curves import differences, estimates, levels, measured, seed_dots
from luxloop.scenarios.study.figures import picture
from luxloop.scenarios.study.study_file import Study
from luxloop.scenarios.study.study_page import REPORT, numbers, point_runs, report
from luxloop.scenarios.study.sweep_runs import Sweep

STUDY = """
description = "How long, and at which speed & <manner>."
scenario = "luxloop.scenarios.study.staged:hidden_behind_wall"
seeds = 3
[[vary]]
key = "occlusion_s"
label = "hidden [s]"
values = [1.0, 2.0]
[[vary]]
key = "manoeuvre"
values = ["keeps speed", "brakes"]
[[curve]]
metric = "track.reappearance_error_m"
against = "occlusion_s"
by = "manoeuvre"
[[curve]]
metric = "track.occlusion_survival"
against = "occlusion_s"
by = "manoeuvre"
kind = "map"
[[curve]]
title = "Panels"
metric = "track.occlusion_survival"
against = "manoeuvre"
panels = "occlusion_s"
"""

ERRORS = {
    (1.0, "keeps speed"): (1.0, 2.0, 3.0, 2.5, 90.0),
    (1.0, "brakes"): (2.0, 3.5, 4.5, 2.0, 95.0),
    (2.0, "keeps speed"): (4.0, 4.0, 6.0, 5.0, math.nan),
    (2.0, "brakes"): (5.0, 7.0, 9.0, 6.0, 50.0),
}
"""[m] Errors by parameters, one per seed."""


@pytest.fixture
def study(tmp_path):
    path = tmp_path / "small.toml"
    path.write_text(STUDY, encoding="utf-8")
    return Study.load(path)


@pytest.fixture
def rows():
    """Twenty runs, and one that failed."""
    found = [
        {"occlusion_s": time, "manoeuvre": manoeuvre, "seed": seed, "status": "passed", "error": "",
         "track.reappearance_error_m": error, "track.occlusion_survival": float(error < 4.0)}
        for (time, manoeuvre), errors in ERRORS.items()
        for seed, error in enumerate(errors, start=1)
    ]  # fmt: skip
    crash = {
        "occlusion_s": 1.0,
        "manoeuvre": "brakes",
        "seed": 6,
        "status": "error",
        "error": "KeyError: <b>'lane'</b>",
    }
    table = pd.DataFrame([*found, crash])
    return table.assign(index=range(len(table)), key=[f"k{n}" for n in range(len(table))], wall_s=1.5)


def test_a_point_is_the_median_over_seeds_and_counts_missing_values(rows):
    found = estimates(measured(rows), "track.reappearance_error_m", ["manoeuvre", "occlusion_s"])
    assert found["manoeuvre"].tolist() == ["keeps speed"] * 2 + ["brakes"] * 2
    assert found["occlusion_s"].tolist() == [1.0, 2.0] * 2
    assert found["value"].tolist() == [2.5, 4.5, 3.5, 7.0]
    assert found["mean"].tolist() == pytest.approx([98.5 / 5, 19 / 4, 107 / 5, 77 / 5])
    assert found["n"].tolist() == [5, 4, 5, 5]
    assert found["runs"].tolist() == [5] * 4
    assert (found["low"][0], found["high"][0]) == (1.0, 90.0)  # of five values the extremes
    assert math.isnan(found["low"][1])  # four seeds have no interval


def test_runs_of_one_seed_count_once(rows):
    """Over both times, 'brakes' has the seeds' means 3.5, 5.25, 6.75, 4 and 72.5.

    Fails if the ten runs are treated as independent samples.
    """
    brakes = estimates(measured(rows), "track.reappearance_error_m", ["manoeuvre"]).set_index("manoeuvre").loc["brakes"]
    assert (brakes["value"], brakes["low"], brakes["high"]) == (5.25, 3.5, 72.5)
    assert (brakes["n"], brakes["seeds"]) == (10, 5)


def test_a_binary_metric_has_an_exact_interval_over_seeds_also_if_all_runs_agree(rows):
    found = estimates(measured(rows), "track.occlusion_survival", ["occlusion_s", "manoeuvre"])
    last = found.iloc[-1]  # none of five survives: at most 1 - 0.05**(1/5)
    assert (last["value"], last["low"]) == (0.0, 0.0)
    assert last["high"] == pytest.approx(1 - 0.05**0.2)
    assert found.iloc[0]["value"] == pytest.approx(0.8)


def test_runs_of_one_seed_are_one_trial_of_a_binary_metric(rows):
    """Fails if ten runs of five seeds are ten trials."""
    agreeing = measured(rows).assign(**{"track.occlusion_survival": lambda table: (table["seed"] > 1).astype(float)})
    once = estimates(agreeing, "track.occlusion_survival", ["manoeuvre", "occlusion_s"]).iloc[0]
    twice = estimates(agreeing, "track.occlusion_survival", ["manoeuvre"]).iloc[0]
    assert (twice["low"], twice["high"]) == (once["low"], once["high"])
    assert (twice["n"], once["n"]) == (10, 5)


def test_differences_pair_runs_that_differ_in_the_curve_only(rows):
    """At 1 s: 1, 1.5, 1.5, -0.5 and 5. At 2 s the last seed has no partner."""
    found = differences(
        measured(rows), "track.reappearance_error_m", ["manoeuvre", "occlusion_s"], "manoeuvre",
        ["occlusion_s", "manoeuvre"],
    )  # fmt: skip
    assert found["manoeuvre"].tolist() == ["brakes"] * 2
    assert found["value"].tolist() == [1.5, 2.0]
    assert (found["low"][0], found["high"][0]) == (-0.5, 5.0)
    assert found["n"].tolist() == [5, 4]


def test_differences_of_shares_stay_within_their_range(rows):
    found = differences(
        measured(rows), "track.occlusion_survival", ["manoeuvre", "occlusion_s"], "manoeuvre",
        ["occlusion_s", "manoeuvre"],
    )  # fmt: skip
    assert found["value"].tolist() == pytest.approx([-0.2, 0.0])
    assert found["low"].between(-1.0, 0.0).all()
    assert (found["high"] > 0.0).all()  # seeds that agree do not make the difference certain


def test_dots_are_the_single_seeds(rows):
    dots = seed_dots(measured(rows), "track.reappearance_error_m", ["manoeuvre", "occlusion_s"])
    assert len(dots) == 19
    both = seed_dots(measured(rows), "track.reappearance_error_m", ["manoeuvre"])
    assert both[both["manoeuvre"] == "brakes"]["value"].tolist() == [3.5, 5.25, 6.75, 4.0, 72.5]


def test_many_distinct_numbers_are_binned_by_quantiles():
    binned = levels(pd.Series(np.arange(80.0)))
    assert len(binned.cat.categories) == 8
    assert binned.value_counts().tolist() == [10] * 8
    assert binned.cat.categories[0] == 4.5
    assert levels(pd.Series(["b", "a", "b"])).cat.categories.tolist() == ["b", "a"]


class Page(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.links, self.tags, self.text = [], [], ""
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        self.links += [value for name, value in attributes if name in ("src", "href") and not value.startswith("data:")]

    def handle_data(self, text):
        self.text += text


def test_the_report_page_contains_all_figures_numbers_and_failures(study, rows, tmp_path):
    path = report(Sweep(study, rows, 22), tmp_path / "out")
    assert path == tmp_path / "out" / REPORT
    page = Page(path.read_text(encoding="utf-8"))
    assert page.tags.count("svg") == 3
    assert all(link.startswith("#") for link in page.links)
    assert "21 of 22" in page.text
    assert "How long, and at which speed & <manner>." in page.text
    assert "KeyError: <b>'lane'</b>" in page.text
    assert "b" not in page.tags
    assert "4 of 5" in page.text
    assert "minus keeps speed" in page.text
    assert "-0.5 to 5" in page.text
    assert "fewer than 5 seeds" in page.text


def test_every_figure_is_written_as_a_non_blank_png(study, rows, tmp_path):
    from matplotlib.image import imread

    report(Sweep(study, rows, 13), tmp_path)
    files = sorted((tmp_path / "pictures").iterdir())
    assert [file.name for file in files] == [
        "01-reappearance_error_m.png",
        "02-occlusion_survival.png",
        "03-occlusion_survival.png",
    ]
    for file in files:
        assert np.ptp(imread(file)[..., :3]) > 0.5


@pytest.mark.slow
def test_figures_are_also_written_in_the_formats_asked_for(study, rows, tmp_path):
    report(Sweep(study, rows, 13), tmp_path, ["svg", "pdf"])
    names = sorted(path.name for path in (tmp_path / "pictures").iterdir())
    stems = sorted({path.stem for path in (tmp_path / "pictures").iterdir()})
    assert len(stems) == len(study.curve)
    assert names == sorted(f"{stem}.{suffix}" for stem in stems for suffix in ("pdf", "png", "svg"))


def test_a_caption_describes_the_interval(study, rows):
    error, _, panels = (picture(study, measured(rows), curve, "name") for curve in study.curve)
    assert "median over seeds" in error.caption
    assert "order statistics" in error.caption
    assert "hollow" in error.caption
    assert "only 5 seeds" in error.caption
    assert "in 3 of 4 points one seed has more than half of the sum" in error.caption
    assert "share of runs" in panels.caption
    assert "exact, over seeds" in panels.caption
    assert panels.title == "Panels"


def test_a_study_without_completed_runs_has_a_page(study, rows, tmp_path):
    page = report(Sweep(study, rows[rows["status"] == "error"], 12), tmp_path).read_text(encoding="utf-8")
    assert "no run has a value" in page


@pytest.mark.slow
def test_shipped_studies_are_valid_and_small_enough():
    """Each takes at most ten minutes on two cores; measured processor time per run, plus 25 %."""
    from luxloop.scenarios.files import shipped
    from luxloop.scenarios.search.thresholds import settings_of
    from luxloop.scenarios.study import design

    seconds = {"hidden_behind_wall": 1.3, "partly_hidden": 1.4, "standing_car": 0.4, "fault-free": 3.8}
    seconds |= dict.fromkeys(("behind_row", "hidden_with_failed_unit", "passed_by_bus"), 1.5)
    seconds |= dict.fromkeys(("behind_parked_truck", "past_house", "behind_turning_bus", "cut_in_past_lorry"), 6.5)
    for path in shipped.studies().values():
        loaded = Study.load(path)
        if loaded.search:
            continue
        if loaded.threshold:
            runs = loaded.threshold.runs * len(settings_of(loaded, loaded.threshold))
        else:
            assert loaded.curve
            runs = len(design.runs(loaded, "luxloop.tracker.tracker:Tracker"))
        assert runs * seconds[loaded.scenario.rpartition(":")[2]] / 2 < 600.0


def test_counts_have_the_share_of_seeds_with_any(study, rows):
    counted = measured(rows).assign(**{"track.id_switches": 0.0})
    counted.loc[counted["seed"] == 2, "track.id_switches"] = [0.0, 3.0, 0.0, 0.0]
    curve = study.curve[0].model_copy(update={"metric": "track.id_switches", "by": None})
    table = numbers(study, counted, curve)
    assert [column.head for column in table.columns] == [
        "hidden [s]",
        "median",
        "95 %",
        "mean",
        "seeds with any",
        "95 %",
        "runs",
    ]
    first, second = ([plain(cell) for cell in row.cells] for row in table.rows)
    low, high = mid_p_interval(1, 5)
    assert first[1:] == ["0", "0 to 1.5", "0.3", "20%", f"{low:.0%} to {high:.0%}", "10"]
    assert second[1:] == ["0", "0 to 0", "0", "0%", "at most 45%", "10"]


def test_each_point_names_its_runs_and_links_to_the_folders_that_are_kept(study, rows, tmp_path):
    curve = study.curve[0]
    table = point_runs(study, measured(rows), curve, None)
    assert not any(span.link for row in table.rows for cell in row.cells for span in cell)
    known = measured(rows)[measured(rows)[curve.metric].notna()]
    lowest = known.sort_values([curve.metric, "index"]).iloc[0]
    (tmp_path / str(lowest["key"])).mkdir()
    linked = [
        span.text
        for row in point_runs(study, measured(rows), curve, str(tmp_path)).rows
        for cell in row.cells
        for span in cell
        if span.link == (tmp_path / str(lowest["key"])).as_uri()
    ]
    assert linked[0] == f"{lowest[curve.metric]:.3g} (run {lowest['index']}, seed {lowest['seed']})"
    assert all(
        span.link.startswith("s3://bucket/x/")
        for row in point_runs(study, measured(rows), curve, "s3://bucket/x/").rows
        for cell in row.cells[len(curve.keys) :]
        for span in cell
    )


def test_the_runs_of_the_points_are_in_the_order_of_the_study(study, rows):
    curve, known = study.curve[0], measured(rows)
    first = known["manoeuvre"].iloc[0]
    raised = known.assign(**{curve.metric: known[curve.metric] + 100.0 * (known["manoeuvre"] == first)})
    points = [[plain(cell) for cell in row.cells[:2]] for row in point_runs(study, raised, curve, None).rows]
    assert points == [[plain(cell) for cell in row.cells[:2]] for row in numbers(study, raised, curve).rows]
    assert first in points[0]
