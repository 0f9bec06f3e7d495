"""Comparison of the selection with its candidates over finished runs: against the metrics, and by hand."""

import math

import numpy as np
import pandas as pd
import pytest
from fits import coverage, observations
from fits.league import FEWEST, standings
from fits.league_tables import summary, table
from support import short_run

from luxloop.scenarios.metrics.definition import filtered
from luxloop.scenarios.metrics.definitions import POINT_BANDS, RANGE_BANDS, VIEWS
from luxloop.scenarios.run import run_folder
from luxloop.scenarios.statistics.intervals import FEWEST_CLUSTERS
from luxloop.tracker.records import METHODS


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs") / "short"
    folder.mkdir()
    run_folder.write(folder, short_run.result(), [], "")
    return folder


def test_errors_are_those_of_the_metrics_overall_by_view_and_by_band(run):
    metrics, observed = short_run.result().metrics, observations.of_runs([run])
    scopes = {"all": {}}
    scopes |= {view.replace("_", "-"): {"view": view} for view in VIEWS.values()}
    scopes |= {observations.label(band, "m"): {"range": band} for band in RANGE_BANDS}
    scopes |= {observations.label(band, "points"): {"points": band} for band in POINT_BANDS}
    seen = 0
    for name, group in observations.groups(observed):
        for method in ("best", "oracle", *METHODS):
            metric = metrics[filtered("fit.heading_abs_mean_deg", method=method, **scopes[name])]
            assert len(group) == metric.n
            if metric.n:
                assert group[method].mean() == pytest.approx(metric.value)
                seen += 1
    assert seen >= 3 * (len(METHODS) + 2)


def test_coverage_is_that_of_the_metrics(run):
    metrics, observed = short_run.result().metrics, observations.of_runs([run])
    within = (observed["deviation"] <= 1.6448536269514722).mean()
    assert within == pytest.approx(metrics["fit.coverage_90"].value)
    assert f"| {100 * within:.1f} %" in coverage.table(observed)


def test_a_run_of_an_earlier_version_has_no_coverage(run, tmp_path):
    result = run_folder.read(run)
    fits = result.tables["fits"].drop(columns=["box_heading_ego_rad", "box_heading_std_deg", "box_heading_error_deg"])
    result.tables["fits"] = fits
    run_folder.write(tmp_path, result, [], "")
    observed = observations.of_runs([tmp_path])
    assert observed["deviation"].isna().all()
    assert "run the scenarios again" in coverage.table(observed)


def made(vehicles, each, **errors):
    """Observations of so many vehicles; an error of a method is a number, or one per vehicle."""
    vehicle = np.repeat(np.arange(vehicles), each)
    columns = {name: np.repeat(np.broadcast_to(error, vehicles), each) for name, error in errors.items()}
    return pd.DataFrame(
        {
            "vehicle": vehicle,
            "view": "rear",
            "range": "0-15 m",
            "points": "0-30 points",
            **dict.fromkeys((*METHODS, "best", "oracle"), 3.0),
            **columns,
        }
    )


def test_the_selection_wins_ties_and_loses():
    shift = np.array([-0.6, -0.2, 0.2, 0.6])
    (all_, rear, _, _) = standings(made(4, 10, best=1.0, tlinkage=0.5), "one")
    assert (all_.group, rear.group, rear.n, rear.vehicles) == ("all", "rear", 40, 4)
    assert rear.verdict == "loses"
    assert [one.method for one in rear.losses] == ["tlinkage"]
    assert rear.differences[0].mean == pytest.approx(0.5)
    assert rear.differences[0].interval == pytest.approx((0.5, 0.5))
    tied = standings(made(4, 10, best=1.0, tlinkage=0.95 + shift), "one")[0]
    assert tied.verdict == "ties"
    assert tied.differences[0].interval[0] < 0.0 < tied.differences[0].interval[1]
    assert standings(made(4, 10, best=1.0, tlinkage=1.5), "one")[0].verdict == "wins"


def test_few_vehicles_have_no_verdict_and_few_observations_no_row():
    few = standings(made(FEWEST_CLUSTERS - 1, 10, best=1.0, tlinkage=0.5), "one")[0]
    assert (few.verdict, few.differences[0].interval) == ("too few vehicles", None)
    assert standings(made(1, FEWEST - 1), "one") == []


def test_observations_without_a_rectangle_of_a_candidate_do_not_count_for_it():
    (standing, *_) = standings(made(3, 10, best=1.0, tlinkage=np.array([math.nan, 0.5, 0.5])), "one")
    assert standing.means["tlinkage"] == pytest.approx(0.5)
    assert standing.differences[0].interval is None  # two vehicles are left


def test_tables_name_the_loss_and_the_least_error():
    rows = standings(made(4, 10, best=1.0, tlinkage=0.5), "one")
    text = table(rows, by_scenario=True)
    assert "| one | all | 40 | 4 | 3.00 |" in text
    assert "**0.50**" in text
    assert "+0.50 [+0.50, +0.50] (tlinkage) | **loses** to tlinkage |" in text
    assert summary(rows) == "Of 4 groups, best: 0 wins, 0 ties, 4 loses."
