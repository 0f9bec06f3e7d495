"""Losses in one scenario of many are found, by exact tests, and chance is not."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support import recorded
from support.few import few

from luxloop.scenarios.compare.compared_metrics import COMPARED_METRICS
from luxloop.scenarios.compare.comparison import LossTest, candidates, compare, loss_test
from luxloop.scenarios.compare.run_pairs import Side, pair
from luxloop.scenarios.compare.vehicle_sums import COLUMNS, SUMS, VehicleSums

METRIC = next(metric for metric in COMPARED_METRICS if metric.name == "fit.heading_abs_mean_deg")
SCENARIOS = 49
LARGE = 3


def pool(runs):
    """Repeat the recorded runs under the names of 49 scenarios; `LARGE` has the vehicles of all of them."""
    named = [replace(runs[n % len(runs)], scenario=f"scenario-{n:02d}", seed=1) for n in range(SCENARIOS)]
    named[LARGE] = replace(joined(runs), scenario=named[LARGE].scenario, seed=named[LARGE].seed)
    return named


def joined(runs):
    """Return a run with the vehicles of several runs, under new ids."""
    ids, sums, matches, truth = [], [], [], []
    for n, vehicles in enumerate(run.vehicles for run in runs):
        ids.append(vehicles.vehicle + 1000 * n)
        sums.append(vehicles.sums)
        matches.append(vehicles.matches + np.eye(1, vehicles.matches.shape[1], dtype=np.int64) * 1000 * n)
        truth.append(vehicles.truth)
    parts = [np.concatenate(part) for part in (ids, sums, matches, truth)]
    return replace(runs[0], vehicles=VehicleSums(*parts))


def against(base, head):
    def side(runs):
        return Side(Path("runs"), {run.key: run for run in runs}, [])

    return compare(pair(side(base), side(head)))


def jittered(run, rng, share=0.001):
    """Multiply every sum of an error by a random factor close to 1."""
    errors = [SUMS.index(name) for name in SUMS if name.endswith(("_m", "_deg"))]
    sums = run.vehicles.sums.copy()
    sums[:, errors] *= 1.0 + rng.normal(0.0, share, sums[:, errors].shape)
    return replace(run, trace_hash="jittered", vehicles=replace(run.vehicles, sums=sums))


def worse_fits(run, share):
    """Increase every heading error of the fits by a share."""
    sums = run.vehicles.sums.copy()
    sums[:, SUMS.index("fit_heading_deg")] *= 1.0 + share
    return replace(run, trace_hash="worse", vehicles=replace(run.vehicles, sums=sums))


def test_loss_of_two_percent_in_one_of_49_scenarios_is_worse():
    base, head = pool(recorded.base()), pool(recorded.base())
    head[LARGE] = worse_fits(head[LARGE], 0.02)
    comparison = against(base, head)
    assert comparison.measured == 1
    assert [c.metric.name for c in comparison.changes if c.verdict == "worse"] == [METRIC.name]


def test_tracks_withheld_in_one_of_49_scenarios_are_worse():
    base, head = pool(recorded.base()), pool(recorded.base())
    changed = [run.with_tracks(recorded.withhold(1, share=0.02), "withheld") for run in recorded.runs()]
    head[LARGE] = replace(joined(changed), scenario=base[LARGE].scenario, seed=base[LARGE].seed)
    comparison = against(base, head)
    assert comparison.verdict == "worse"


def test_loss_in_one_scenario_is_found_while_all_others_vary():
    rng = np.random.default_rng(1)
    base = pool(recorded.base())
    head = [jittered(run, rng) for run in base]
    head[LARGE] = worse_fits(head[LARGE], 0.05)
    comparison = against(base, head)
    assert comparison.measured == SCENARIOS
    assert [(loss.scenario, loss.metric.name) for loss in comparison.scenario_losses] == [("scenario-03", METRIC.name)]
    assert comparison.verdict == "worse"


@pytest.mark.parametrize("seed", few(range(40), *range(8)))
def test_chance_in_a_large_pool_is_never_worse(seed):
    rng = np.random.default_rng(seed)
    base = pool(recorded.base())[:12]
    comparison = against(base, [jittered(run, rng, share=0.01) for run in base])
    assert comparison.scenario_losses == []
    assert comparison.verdict == "same"


def test_loss_in_a_scenario_with_few_vehicles_cannot_be_told_from_chance():
    base, head = pool(recorded.base()), pool(recorded.base())
    few = base[0].vehicles
    few = replace(few, vehicle=few.vehicle[:4], sums=few.sums[:4], matches=few.matches[:0], truth=few.truth[:4])
    base[0] = replace(base[0], vehicles=few)
    head[0] = worse_fits(base[0], 0.05)
    assert against(base, head).verdict == "cannot tell"


# --- the test of one scenario, by hand


def sums_of(errors):
    """A vehicle per error; each was fitted in 10 frames."""
    sums = np.zeros((len(errors), len(COLUMNS)))
    sums[:, COLUMNS.index("fitted")] = 10.0
    sums[:, COLUMNS.index("fit_heading_deg")] = errors
    return sums


def test_p_value_is_exact():
    """Of the 32 exchanges of five vehicles, each worse by one, only one is as extreme."""
    test = loss_test(sums_of([10.0] * 5), sums_of([11.0] * 5), (METRIC,))
    assert test.relevant_p.tolist() == [1 / 32]
    assert (test.attainable_p, test.units) == (1 / 32, 5)
    assert test.loss[0] == pytest.approx(0.1)


def test_vehicles_that_do_not_differ_do_not_count():
    test = loss_test(sums_of([10.0] * 5), sums_of([10.0, 10.0, 11.0, 9.0, 12.0]), (METRIC,))
    # Sums of exchanged signs of (1, -1, 2) that reach 2: those with a positive third sign, except (-1, -1, 2): 3 of 8.
    assert (test.units, test.relevant_p.tolist()) == (3, [3 / 8])


def test_improvement_and_irrelevant_loss_have_a_p_value_of_one():
    assert loss_test(sums_of([10.0] * 9), sums_of([9.0] * 9), (METRIC,)).smallest_p == 1.0
    assert loss_test(sums_of([10.0] * 9), sums_of([10.05] * 9), (METRIC,)).smallest_p == 1.0
    assert loss_test(sums_of([10.0] * 9), sums_of([10.0] * 9), (METRIC,)) is None


def test_scenarios_without_any_possible_significance_are_no_candidates():
    def of(units):
        nothing = np.zeros(1)
        return LossTest(nothing, nothing, nothing, np.ones(1), 2.0**-units, units)

    tests = {"three": of(3), "eight": of(8), "nine": of(9), "twenty": of(20)}
    # At 0.005, three (0.125) is never possible, and eight (0.0039) not among two (0.0025 each); nine is (0.00195).
    assert candidates(tests, 0.005) == {"nine", "twenty"}
    assert candidates({"eight": of(8), "three": of(3)}, 0.005) == {"eight"}
    assert candidates({}, 0.005) == set()
