"""What vehicles add to HOTA, CLEAR and Identity adds up to what trackeval says, and the other sums to the metrics."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support import recorded
from support.sequences import random_sequence
from trackeval.metrics import CLEAR, HOTA, Identity

from scenarios.compare.compared_metrics import COMPARED_METRICS
from scenarios.compare.sums import COLUMNS, SUMS, VehicleSums
from scenarios.compare.vehicle_sums import ALPHAS, match
from scenarios.grading import track_metrics
from sensor_model.truth import NO_ACTOR

LIMIT = {"THRESHOLD": 0.5, "PRINT_CONFIG": False}
RATES = {
    "track.missed_rate": "track.missed",
    "track.false_rate": "track.false",
    "track.id_switch_rate": "track.id_switches",
}
NAMED_AS_IN_A_RESULT = [
    headline for headline in COMPARED_METRICS if headline.name not in {*RATES, "track.heading_unflipped_mean_deg"}
]


@given(st.integers(0, 2**32 - 1), st.integers(0, 4), st.integers(0, 4))
@settings(deadline=None, max_examples=60)
def test_matches_add_up_to_what_trackeval_counts(seed, vehicles, tracks):
    data = random_sequence(seed, vehicles, tracks)
    found = match(data, 0.5)
    clear, identity = CLEAR(dict(LIMIT)).eval_sequence(data), Identity(dict(LIMIT)).eval_sequence(data)
    hota = HOTA().eval_sequence(data)
    assert found.hits.sum() == clear["CLR_TP"]
    assert found.switches.sum() == clear["IDSW"]
    assert found.identified.sum() == identity["IDTP"]
    matched = found.overlaps[:, :, :0:-1].cumsum(axis=2)[:, :, ::-1]
    assert matched.sum(axis=(0, 1)).tolist() == hota["HOTA_TP"].tolist()


def test_the_sums_of_hota_by_hand():
    """A car is seen in 10 frames, its track in 8, on the car in 6 of them, and in 4 of these with an overlap of 0.9."""
    matches = np.zeros((1, 2 + len(ALPHAS)), dtype=np.int64)
    matches[0, :2] = 7, 8
    matches[0, 2 + np.searchsorted(ALPHAS, 0.61) - 1] = 2
    matches[0, 2 + len(ALPHAS) - 2] = 4
    sums = np.zeros((2, len(SUMS)))
    sums[1, :2] = 10, 8
    columns = dict(zip(COLUMNS, VehicleSums(np.array([NO_ACTOR, 7]), sums, matches).columns().T.tolist(), strict=True))
    assert columns["matched_0.05"] == columns["matched_0.60"] == [0, 6]
    assert columns["matched_0.65"] == columns["matched_0.90"] == [0, 4]
    assert columns["matched_0.95"] == [0, 0]
    assert columns["associated_0.60"] == [0, 6 * 6 / (10 + 8 - 6)]
    assert columns["associated_0.90"] == [0, 4 * 4 / (10 + 8 - 4)]


@pytest.mark.parametrize("headline", NAMED_AS_IN_A_RESULT, ids=lambda headline: headline.name)
def test_a_headline_of_one_run_is_the_metric_of_its_result(headline):
    for run, kept in zip(recorded.runs(), recorded.base(), strict=True):
        value = headline.value(kept.vehicles.columns().sum(axis=0, keepdims=True))[0]
        expected = run.result.metrics[headline.name]
        assert expected.unit == headline.unit
        assert value == pytest.approx(np.nan if expected.value is None else expected.value, rel=1e-5, nan_ok=True)


def test_the_rates_are_the_counts_over_the_observations():
    headlines = {headline.name: headline for headline in COMPARED_METRICS}
    for run, kept in zip(recorded.runs(), recorded.base(), strict=True):
        sums = kept.vehicles.columns().sum(axis=0, keepdims=True)
        metrics = run.result.metrics
        for name, count in RATES.items():
            expected = metrics[count].value / metrics["dataset.observations"].value
            assert headlines[name].value(sums)[0] == pytest.approx(expected)
        flipped = headlines["track.heading_flip_rate"].value(sums)[0]
        assert flipped == 0.0  # so that both means are the same
        mean = headlines["track.heading_unflipped_mean_deg"].value(sums)[0]
        assert mean == pytest.approx(metrics["track.heading_abs_mean_deg"].value, rel=1e-5)


def test_runs_are_pooled_as_trackeval_combines_sequences():
    sequences = [
        track_metrics.sequence(*(run.result.tables[name] for name in ("truth", "tracks", "overlaps")))
        for run in recorded.runs()
    ]
    sums = np.vstack([kept.vehicles.columns() for kept in recorded.base()]).sum(axis=0, keepdims=True)
    values = {headline.name: headline.value(sums)[0] for headline in COMPARED_METRICS}
    for name, metric in {"HOTA": HOTA(), "MOTA": CLEAR(dict(LIMIT)), "IDF1": Identity(dict(LIMIT))}.items():
        combined = metric.combine_sequences({str(i): metric.eval_sequence(s) for i, s in enumerate(sequences)})
        assert values[f"track.{name.lower()}"] == pytest.approx(np.mean(combined[name]), abs=1e-9)


def test_what_was_not_there_to_see_has_no_value():
    nothing = np.zeros((1, len(COLUMNS)))
    assert all(np.isnan(headline.value(nothing)[0]) for headline in COMPARED_METRICS)
