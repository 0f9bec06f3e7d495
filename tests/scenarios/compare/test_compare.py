"""Neutral changes are never flagged, losses of 2 % always are, and failures are separate from both."""

from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from support import recorded, short_run

from luxloop.scenarios.compare.compared_metrics import COMPARED_METRICS
from luxloop.scenarios.compare.comparison import compare, judge
from luxloop.scenarios.compare.digest import Expectation, digest
from luxloop.scenarios.compare.resampling import Difference, differences
from luxloop.scenarios.compare.run_pairs import Side, pair
from luxloop.scenarios.compare.vehicle_sums import COLUMNS, SUMS
from luxloop.scenarios.files import shipped
from luxloop.scenarios.files.scenario import Scenario

FLAGGED = ("better", "worse", "lost")
METRIC = {metric.name: metric for metric in COMPARED_METRICS}


def side(runs):
    return Side(Path("runs"), {run.key: run for run in runs}, [])


def against(base, head):
    return compare(pair(side(base), side(head)))


def changed(change):
    """Comparison of all recorded runs with the same runs with changed tracks."""
    return against(recorded.base(), [run.with_tracks(change, "changed") for run in recorded.runs()])


def flagged(comparison):
    return {change.metric.name: change.verdict for change in comparison.changes if change.verdict in FLAGGED}


def seeds(quick, of):
    """Seeds as parameters: `quick` of them in `make test`, all in `make slow`."""
    return [*range(quick), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(quick, of))]


# --- a neutral change


@pytest.mark.parametrize("seed", seeds(2, of=20))
def test_jitter_of_a_millimetre_is_never_flagged(seed):
    comparison = changed(recorded.jitter(seed, sigma_m=0.001))
    assert flagged(comparison) == {}
    assert comparison.verdict == "same"
    assert any(change.numbers.difference for change in comparison.changes)  # the jitter has an effect


@pytest.mark.slow
def test_another_order_of_the_points_is_never_flagged():
    """Any order in any two of the four runs. Fits do not depend on it; segments and tracks are numbered by it."""
    orders = [recorded.base()]
    orders += [
        [run.with_device(recorded.Shuffled(seed), f"shuffled {seed}") for run in recorded.runs()] for seed in (1, 2)
    ]
    choices = [(a, b, (a + b) % 3, (a + 2 * b) % 3) for a, b in product(range(3), repeat=2)][1:]
    compared = [against(orders[0], [orders[order][i] for i, order in enumerate(choice)]) for choice in choices]
    assert [flagged(comparison) for comparison in compared] == [{}] * 8
    assert {change.verdict for change in compared[-1].changes} == {"same"}
    assert not all(pair.identical for pair in compared[-1].pairs.compared)  # other scans, in another order


def test_identical_runs_have_no_difference():
    comparison = against(recorded.base(), recorded.base())
    assert all(pair.identical for pair in comparison.pairs.compared)
    assert {change.numbers.interval for change in comparison.changes} == {(0.0, 0.0)}
    assert {(change.numbers.difference, change.verdict) for change in comparison.changes} == {(0.0, "same")}


# --- a loss of 2 %


@pytest.mark.parametrize("seed", seeds(2, of=8))
def test_two_percent_of_the_tracks_withheld_are_flagged_every_time(seed):
    comparison = changed(recorded.withhold(seed, share=0.02))
    found = flagged(comparison)
    assert found.keys() >= {"track.mota", "track.missed_share", "track.hota"}
    assert comparison.verdict == "worse"
    assert "better" not in found.values()


def test_positions_two_percent_worse_are_flagged():
    found = flagged(changed(recorded.worse_position(0.02)))
    assert found
    assert set(found.values()) == {"worse"}
    assert all(name.startswith(("mma.x_abs", "mma.y_abs")) for name in found)


@pytest.mark.slow
def test_headings_two_percent_worse_are_flagged_and_nothing_else(tmp_path):
    """With an ideal ego no error is close to 90 degrees: one that grows beyond is a flip, which the mean omits."""
    street, ideal = short_run.write(tmp_path, recorded.STREET, "street"), {"noise": {"ideal": True}}
    scenarios = [Scenario.load(street, {"seed": seed, **ideal}) for seed in (1, 2, 3)]
    scenarios.append(Scenario.load(shipped.find("sumo-crossing"), {"duration_s": 6.0, **ideal}))
    runs = [recorded.Recorded.of(scenario) for scenario in scenarios]
    base = [digest(run.result) for run in runs]

    def found(share):
        return flagged(against(base, [run.with_tracks(recorded.worse_heading(share), "changed") for run in runs]))

    assert found(0.02) == {"track.heading_unflipped_mean_deg": "worse"}
    assert found(-0.02) == {"track.heading_unflipped_mean_deg": "better"}


@pytest.mark.parametrize(
    ("column", "name"),
    [
        ("fit_heading_deg", "fit.heading_abs_mean_deg"),
        ("fit_position_m", "fit.position_abs_mean_m"),
        ("moving_y_m", "mma.y_abs_mean_m{target=moving}"),
        ("moving_x_m", "mma.x_abs_mean_m{target=moving}"),
    ],
)
def test_every_error_that_grows_by_two_percent_is_flagged(column, name):
    found = flagged(against(recorded.base(), [scaled(run, column, 1.02) for run in recorded.base()]))
    assert found == {name: "worse"}


def scaled(run, column, factor):
    sums = run.vehicles.sums.copy()
    sums[:, SUMS.index(column)] *= factor
    return replace(run, trace_hash="scaled", vehicles=replace(run.vehicles, sums=sums))


def test_runs_with_the_largest_contributions_are_named_largest_first():
    first, *others = recorded.base()
    head = [scaled(first, "fit_heading_deg", 1.3), *(scaled(run, "fit_heading_deg", 1.02) for run in others)]
    change = next(c for c in against(recorded.base(), head).changes if c.metric.name == "fit.heading_abs_mean_deg")
    assert change.verdict == "worse"
    assert next(iter(change.where)) == first.key
    moved = list(change.where.values())
    assert moved == sorted(moved, reverse=True)


# --- the statistics


@pytest.mark.slow
def test_false_positive_rate_is_the_level():
    """BASE and HEAD of vehicles with any number of frames differ at random, and by far more than the margin.

    At a level of 10 %, 200 comparisons flag 20 by chance; without the correction for many metrics they would flag 160.
    """
    rng = np.random.default_rng(7)
    smallest = [
        min(difference.p for difference in differences(*random_sums(rng, units=12), COMPARED_METRICS))
        for _ in range(200)
    ]
    assert 6 <= sum(p <= 0.1 for p in smallest) <= 34  # 20 is the mean, 4.2 its standard deviation


def random_sums(rng, units):
    """Random sums of vehicles with a random number of frames, for BASE and for HEAD."""
    size = rng.integers(5, 400, size=(units, 1)).astype(float)
    return [size * rng.uniform(0.2, 1.0, size=(units, len(COLUMNS))) for _ in "ab"]


def test_coverage_of_the_interval():
    """The errors of 60 vehicles grow by 0.1 on average: 95 % of the intervals should contain this value."""
    rng = np.random.default_rng(3)
    metric = METRIC["fit.heading_abs_mean_deg"]
    fitted, error = COLUMNS.index("fitted"), COLUMNS.index("fit_heading_deg")
    covered = 0
    for _ in range(100):
        base = np.zeros((60, len(COLUMNS)))
        base[:, fitted] = 50.0
        base[:, error] = 50.0 * rng.gamma(2.0, 0.5, size=60)
        head = base.copy()
        head[:, error] += 50.0 * rng.normal(0.1, 0.2, size=60)
        low, high = differences(base, head, (metric,))[0].interval
        covered += low <= 0.1 <= high
    assert 88 <= covered <= 99


def test_p_value_of_a_difference_by_hand():
    """Five vehicles, each worse by one: of the 32 exchanges, 2 are as extreme (exact sign test, p = 1/16)."""
    metric = METRIC["fit.heading_abs_mean_deg"]
    base = np.zeros((5, len(COLUMNS)))
    base[:, COLUMNS.index("fitted")] = 10.0
    base[:, COLUMNS.index("fit_heading_deg")] = 10.0
    head = base.copy()
    head[:, COLUMNS.index("fit_heading_deg")] += 1.0
    assert differences(base, head, (metric,))[0].p == pytest.approx(1 / 16, abs=0.02)


@pytest.mark.parametrize(
    ("base", "head", "interval", "p", "verdict"),
    [
        (0.9, 0.88, (-0.025, -0.015), 0.001, "worse"),
        (0.9, 0.92, (0.015, 0.025), 0.001, "better"),
        (0.9, 0.896, (-0.0045, -0.0035), 0.001, "same"),  # significant, but below the margin
        (0.9, 0.88, (-0.045, 0.005), 0.2, "unclear"),
        (0.9, 0.899, (-0.003, 0.001), 0.9, "same"),
        (0.9, np.nan, (np.nan, np.nan), np.nan, "lost"),
        (np.nan, 0.9, (np.nan, np.nan), np.nan, "not measured"),
    ],
)
def test_verdict_requires_significance_and_relevance(base, head, interval, p, verdict):
    assert judge(METRIC["track.hota"], Difference(base, head, interval, p)) == verdict


def test_metric_without_value_in_head_is_lost_and_worse():
    """For example when a tracker no longer returns a trace."""
    blind = [scaled(scaled(scaled(run, "fitted", 0.0), "segmented", 0.0), "segments", 0.0) for run in recorded.base()]
    comparison = against(recorded.base(), blind)
    assert {change.verdict for change in comparison.changes if change.metric.name.startswith("fit.")} == {"lost"}
    assert comparison.verdict == "worse"


# --- failures are independent of changes


def test_failure_is_not_a_change_and_change_is_not_a_failure():
    first, *others = recorded.base()
    met = replace(first, expectations={"track.hota": Expectation("passed", 0.9, ">= 0.9")})
    missed = replace(first, expectations={"track.hota": Expectation("failed", 0.89, ">= 0.9")})
    comparison = against([met, *others], [missed, *others])
    assert (comparison.failed, comparison.verdict) == (True, "worse")
    assert {change.verdict for change in comparison.changes} == {"same"}
    comparison = against([met, *others], [scaled(run, "hits", 0.9) for run in (met, *others)])
    assert (comparison.failed, comparison.verdict) == (False, "worse")


@pytest.mark.parametrize(
    ("base", "head", "fate"),
    [
        ("passed", "passed", None),
        ("passed", "failed", "newly failed"),
        ("unexpected pass", "failed", "newly failed"),
        ("failed", "failed", "still failing"),
        ("known failure", "failed", "still failing"),
        ("passed", "known failure", "now known to fail"),
        ("known failure", "known failure", None),
        ("failed", "passed", "mended"),
        ("known failure", "unexpected pass", "mended"),
    ],
)
def test_fate_of_an_expectation(base, head, fate):
    first, *others = (replace(run, expectations={}) for run in recorded.base())

    def of(outcome):
        return [replace(first, expectations={"track.hota": Expectation(outcome, 0.5, ">= 0.9")}), *others]

    comparison = against(of(base), of(head))
    assert [change.fate for change in comparison.expectation_changes] == ([] if fate is None else [fate])
    assert comparison.failed == (fate == "newly failed")
