"""Known failures belong to a tracker and carry a range: worse fails, inside is expected, better asks for removal."""

import math

import pytest
from support import short_run
from support.paths import CATALOG

from luxloop.scenarios.compare import baseline_file
from luxloop.scenarios.files import shipped
from luxloop.scenarios.files.expect import SHIPPED, Check, Limit, check, figure_of, tolerance, verdict, worst_values
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.result import Metric
from luxloop.scenarios.run import device

DEG, COUNT, SHARE = "deg", "count", "1"
BASELINE = {run.scenario: run for run in baseline_file.read(CATALOG.parent / "baseline" / "catalog.jsonl")}


def outcome(value, text="2.0: bowed faces", unit=DEG, device=SHIPPED, **limit):
    limit = Limit(**(limit or {"max": 1.35}), known_failure=text)
    return Check("fit.heading_abs_mean_deg", limit, Metric(value, unit, 9), device).outcome


@pytest.mark.parametrize(
    ("text", "figure"),
    [
        ("2.13: cause", 2.13),
        ("-0.00666: cause: 0.1", -0.00666),
        ("3: cause", 3.0),
        ("1.2e-05: cause", 1.2e-5),
        ("the bus is two tracks: 12", None),
        ("2.13 cause", None),
        ("2.13:", None),
        ("", None),
    ],
)
def test_figure_at_the_beginning_of_the_text(text, figure):
    assert figure_of(text) == figure


@pytest.mark.parametrize(
    ("figure", "unit", "expected"),
    [
        (3, COUNT, 2.0),
        (100, COUNT, 30.0),
        (2.0, DEG, 0.2),
        (0.7, SHARE, 0.03),
        (0.3, SHARE, 0.03),
        (0.98, SHARE, 0.01),
        (-0.5, SHARE, 0.05),
    ],
)
def test_tolerance_by_unit(figure, unit, expected):
    assert tolerance(figure, unit) == pytest.approx(expected)


def test_range_begins_at_the_limit_if_the_figure_holds():
    assert worst_values(0.981, 0.97, None, SHARE) == (pytest.approx(0.96), math.inf)
    assert worst_values(0.95, 0.97, None, SHARE) == (pytest.approx(0.94), math.inf)
    assert worst_values(5.0, None, 2.0, COUNT) == (-math.inf, pytest.approx(7.0))


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (1.3, "unexpected pass"),
        (1.4, "known failure"),
        (2.0, "known failure"),
        (2.19, "known failure"),
        (2.21, "failed"),
        (None, "failed"),
    ],
)
def test_worse_than_the_range_fails(value, expected):
    assert outcome(value) == expected


def test_without_a_figure_any_value_is_excused():
    assert outcome(50.0, "bowed faces") == "known failure"
    assert outcome(None, "bowed faces") == "known failure"


def test_another_tracker_is_not_excused_and_not_shown_the_story():
    assert outcome(2.0, device="mine.py:Mine") == "failed"
    assert outcome(1.0, device="mine.py:Mine") == "passed"
    limit = Limit(max=1.35, need="table 2", known_failure="2.0: bowed faces")
    assert Check("track.hota", limit, Metric(2.0, DEG, 9), "mine.py:Mine").why == "table 2"


def test_known_failure_of_another_tracker_excuses_only_that():
    limit = Limit(max=1.35, known_failure="2.0: no model", known_failure_of="mine.py:Mine")
    metrics = {"fit.heading_abs_mean_deg": Metric(2.1, DEG, 9)}
    expect = dict.fromkeys(metrics, limit)
    assert check(metrics, expect, "mine.py:Mine")[0].outcome == "known failure"
    assert check(metrics, expect)[0].outcome == "failed"


def test_reason_of_a_failure_names_the_range():
    limit = Limit(max=1.35, known_failure="2.0: bowed faces")
    why = Check("fit.heading_abs_mean_deg", limit, Metric(2.5, DEG, 9)).why
    assert why == "worse than its known failure (up to 2.2): 2.0: bowed faces"


def test_run_without_any_observation_does_not_pass():
    none = Check("track.false", Limit(max=11.0), Metric(0.0, COUNT, 0))
    some = Check("track.id_switches", Limit(max=0.0), Metric(0.0, COUNT, 9))
    assert verdict([none], complete=True) == "failed"
    assert verdict([none, some], complete=True) == "passed"


def test_other_seeds_and_durations_have_other_figures(tmp_path):
    text = short_run.TEXT + '[expect]\n"track.idf1" = { min = 2.0, known_failure = "0.5: two tracks" }'
    path = short_run.write(tmp_path, text)

    def known(overrides):
        return Scenario.load(path, overrides).expect["track.idf1"].known_failure

    assert known(None) == known({"seed": 4}) == known({"duration_s": 0.8}) == "0.5: two tracks"
    assert known({"seed": 5}) == known({"duration_s": 0.4}) == "two tracks"
    assert Scenario.load(path, {"seed": 5}).path == path


def test_name_of_the_shipped_tracker():
    assert SHIPPED == device.SHIPPED == device.name_of(device.load(device.SHIPPED))


@pytest.mark.parametrize("name", sorted(shipped.paths()))
def test_known_failures_of_the_catalog_have_a_figure(name):
    scenario = Scenario.load(shipped.paths()[name])
    assert scenario.path.resolve().is_relative_to(CATALOG)
    for metric, limit in scenario.expect.items():
        if limit.known_failure:
            figure, value = figure_of(limit.known_failure), BASELINE[name].expectations[metric].value
            assert figure is not None, metric
            above = limit.max is not None and value > limit.max
            loss = figure - value if above else value - figure
            assert loss <= 0.005 * abs(value), f"{metric} is {value:.3g} now: state that, so that no loss is excused"
