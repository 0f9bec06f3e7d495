"""Curves of studies against means and intervals computed by hand, and the report page."""

import math
from html.parser import HTMLParser

import numpy as np
import pandas as pd
import pytest

from scenarios.study.curves import differences, estimates, levels, measured, student, wilson
from scenarios.study.figures import picture
from scenarios.study.study_file import Study
from scenarios.study.study_page import REPORT, report
from scenarios.study.sweep_runs import Sweep

STUDY = """
description = "How long, and at which speed & <manner>."
scenario = "scenarios.study.staged:hidden_behind_wall"
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
    (1.0, "keeps speed"): (1.0, 2.0, 3.0),
    (1.0, "brakes"): (2.0, 3.5, 4.5),
    (2.0, "keeps speed"): (4.0, 4.0, math.nan),
    (2.0, "brakes"): (5.0, 7.0, 9.0),
}
"""[m] Errors by parameters, one per seed."""


@pytest.fixture
def study(tmp_path):
    path = tmp_path / "small.toml"
    path.write_text(STUDY, encoding="utf-8")
    return Study.load(path)


@pytest.fixture
def rows():
    """Twelve runs, and one that failed."""
    found = [
        {"occlusion_s": time, "manoeuvre": manoeuvre, "seed": seed, "status": "passed", "error": "",
         "track.reappearance_error_m": error, "track.occlusion_survival": float(error < 4.0)}
        for (time, manoeuvre), errors in ERRORS.items()
        for seed, error in enumerate(errors, start=1)
    ]  # fmt: skip
    crash = {
        "occlusion_s": 1.0,
        "manoeuvre": "brakes",
        "seed": 4,
        "status": "error",
        "error": "KeyError: <b>'lane'</b>",
    }
    table = pd.DataFrame([*found, crash])
    return table.assign(index=range(len(table)), wall_s=1.5)


def test_student_interval_agrees_with_a_textbook():
    """1, 2, 3: mean 2, deviation 1; t(0.975, 2) = 4.3027 (t table), so 2 +- 4.3027 / sqrt(3)."""
    assert student(np.array([1.0, 2.0, 3.0])) == pytest.approx((2 - 2.4842, 2 + 2.4842), abs=1e-4)
    assert all(map(math.isnan, student(np.array([1.0]))))


def test_wilson_interval_agrees_with_published_values():
    """Newcombe 1998, Statistics in Medicine 17, table I, method 3: 81 of 263, 15 of 148, 0 of 20."""
    assert wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    assert wilson(15, 148) == pytest.approx((0.0624, 0.1605), abs=5e-5)
    assert wilson(0, 20) == pytest.approx((0.0, 0.1611), abs=5e-5)


def test_a_point_is_the_mean_over_seeds_and_counts_missing_values(rows):
    found = estimates(measured(rows), "track.reappearance_error_m", ["manoeuvre", "occlusion_s"])
    assert found["manoeuvre"].tolist() == ["keeps speed"] * 2 + ["brakes"] * 2
    assert found["occlusion_s"].tolist() == [1.0, 2.0] * 2
    assert found["mean"].tolist() == pytest.approx([2.0, 4.0, 10 / 3, 7.0])
    assert found["n"].tolist() == [3, 2, 3, 3]
    assert found["runs"].tolist() == [3, 3, 3, 3]
    assert found["low"].tolist()[0] == pytest.approx(2 - 2.4842, abs=1e-4)


def test_runs_of_one_seed_count_once(rows):
    """Over both times, 'brakes' has the seeds' means 3.5, 5.25 and 6.75: 5.1667 +- 4.3027 * 1.6266 / sqrt(3).

    Fails if the six runs are treated as independent samples.
    """
    found = estimates(measured(rows), "track.reappearance_error_m", ["manoeuvre"]).set_index("manoeuvre")
    brakes = found.loc["brakes"]
    assert brakes["mean"] == pytest.approx(31 / 6)
    assert brakes["high"] - brakes["mean"] == pytest.approx(4.3027 * 1.6266 / math.sqrt(3), abs=1e-3)


def test_a_binary_metric_has_a_wilson_interval_also_if_all_runs_agree(rows):
    found = estimates(measured(rows), "track.occlusion_survival", ["occlusion_s", "manoeuvre"])
    first = found.iloc[0]
    assert (first["mean"], first["low"], first["high"]) == pytest.approx((1.0, *wilson(3, 3)))
    assert first["low"] < 0.5


def test_differences_pair_runs_that_differ_in_the_curve_only(rows):
    """At 1 s: 1, 1.5 and 1.5, so 1.3333 +- 4.3027 * 0.28868 / sqrt(3) = 0.7171: a third of either curve's.

    At 2 s the third seed has no partner: 1 and 3, so 2 +- 12.706 * 1.4142 / sqrt(2).
    """
    found = differences(
        measured(rows), "track.reappearance_error_m", ["manoeuvre", "occlusion_s"], "manoeuvre",
        ["occlusion_s", "manoeuvre"],
    )  # fmt: skip
    assert found["manoeuvre"].tolist() == ["brakes"] * 2
    assert found["mean"].tolist() == pytest.approx([4 / 3, 2.0])
    assert (found["high"] - found["mean"]).tolist() == pytest.approx([0.7171, 12.706], abs=1e-3)
    assert found["n"].tolist() == [3, 2]


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
    path = report(Sweep(study, rows, 14), tmp_path / "out")
    assert path == tmp_path / "out" / REPORT
    page = Page(path.read_text(encoding="utf-8"))
    assert page.tags.count("svg") == 3
    assert all(link.startswith("#") for link in page.links)
    assert "13 of 14" in page.text
    assert "How long, and at which speed & <manner>." in page.text
    assert "KeyError: <b>'lane'</b>" in page.text
    assert "b" not in page.tags
    assert "2 of 3" in page.text
    assert "minus keeps speed" in page.text
    assert "0.616 to 2.05" in page.text


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


def test_figures_are_also_written_in_the_formats_asked_for(study, rows, tmp_path):
    report(Sweep(study, rows, 13), tmp_path, ["svg", "pdf"])
    names = sorted(path.name for path in (tmp_path / "pictures").iterdir())
    stems = sorted({path.stem for path in (tmp_path / "pictures").iterdir()})
    assert len(stems) == len(study.curve)
    assert names == sorted(f"{stem}.{suffix}" for stem in stems for suffix in ("pdf", "png", "svg"))


def test_a_caption_describes_the_interval(study, rows):
    error, _, panels = (picture(study, measured(rows), curve, "name") for curve in study.curve)
    assert "Student's t, over seeds" in error.caption
    assert "hollow" in error.caption
    assert "Wilson, over runs" in panels.caption
    assert panels.title == "Panels"


def test_a_study_without_completed_runs_has_a_page(study, rows, tmp_path):
    page = report(Sweep(study, rows[rows["status"] == "error"], 12), tmp_path).read_text(encoding="utf-8")
    assert "no run has a value" in page


def test_shipped_studies_are_valid_and_small_enough():
    """Each takes at most ten minutes on two cores; measured processor time per run, plus 25 %."""
    from scenarios.files import shipped
    from scenarios.study import design

    seconds = {"hidden_behind_wall": 1.3, "partly_hidden": 1.4, "standing_car": 0.4, "fault-free": 3.8}
    seconds |= dict.fromkeys(("behind_parked_truck", "past_house", "behind_turning_bus", "cut_in_past_lorry"), 6.5)
    for path in shipped.studies().values():
        loaded = Study.load(path)
        if loaded.search:
            continue
        assert loaded.curve
        runs = design.runs(loaded, "tracker.tracker:Tracker")
        assert len(runs) * seconds[loaded.scenario.rpartition(":")[2]] / 2 < 600.0
