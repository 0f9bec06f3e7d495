"""Sums per vehicle: they add up to the metrics of a run, and runs are pooled as by trackeval."""

import numpy as np
import pytest
from support import recorded
from support.optional import need

from luxloop.scenarios.compare.compared_metrics import COMPARED_METRICS
from luxloop.scenarios.compare.vehicle_sums import COLUMNS, SUMS, TRUTH, VehicleSums
from luxloop.scenarios.grading.clear_table import tracking_sequence
from luxloop.scenarios.grading.tracking_scores import ALPHAS
from luxloop.sensor_model.truth import NO_ACTOR

LIMIT = {"THRESHOLD": 0.5, "PRINT_CONFIG": False}
RATES = {
    "track.missed_share": "track.missed",
    "track.false_share": "track.false",
    "track.id_switch_rate": "track.id_switches",
}
NAMED_AS_IN_A_RESULT = [
    metric for metric in COMPARED_METRICS if metric.name not in {*RATES, "track.heading_unflipped_mean_deg"}
]


def test_hota_sums_by_hand():
    """A car is graded in 10 frames, its track reported in 8; they match in 6, and in 4 of these overlap by 0.9."""
    matches = np.zeros((1, 2 + len(ALPHAS)), dtype=np.int64)
    matches[0, :2] = 7, 8
    matches[0, 2 + np.searchsorted(ALPHAS, 0.61) - 1] = 2
    matches[0, 2 + len(ALPHAS) - 2] = 4
    sums = np.zeros((2, len(SUMS)))
    sums[1, :2] = 10, 8
    vehicles = VehicleSums(np.array([NO_ACTOR, 7]), sums, matches, np.zeros((2, len(TRUTH))))
    columns = dict(zip(COLUMNS, vehicles.columns().T.tolist(), strict=True))
    assert columns["matched_0.05"] == columns["matched_0.60"] == [0, 6]
    assert columns["matched_0.65"] == columns["matched_0.90"] == [0, 4]
    assert columns["matched_0.95"] == [0, 0]
    assert columns["associated_0.60"] == [0, 6 * 6 / (10 + 8 - 6)]
    assert columns["associated_0.90"] == [0, 4 * 4 / (10 + 8 - 4)]


@pytest.mark.parametrize("metric", NAMED_AS_IN_A_RESULT, ids=lambda metric: metric.name)
def test_compared_metric_of_one_run_equals_the_metric_of_its_result(metric):
    for run, kept in zip(recorded.runs(), recorded.base(), strict=True):
        value = metric.value(kept.vehicles.columns().sum(axis=0, keepdims=True))[0]
        expected = run.result.metrics[metric.name]
        assert expected.unit == metric.unit
        assert value == pytest.approx(np.nan if expected.value is None else expected.value, rel=1e-5, nan_ok=True)


def test_rates_are_counts_over_observations():
    compared = {metric.name: metric for metric in COMPARED_METRICS}
    for run, kept in zip(recorded.runs(), recorded.base(), strict=True):
        sums = kept.vehicles.columns().sum(axis=0, keepdims=True)
        metrics = run.result.metrics
        for name, count in RATES.items():
            expected = metrics[count].value / metrics["dataset.observations"].value
            assert compared[name].value(sums)[0] == pytest.approx(expected)


def test_unflipped_headings_are_those_with_errors_of_at_most_90_degrees():
    compared = {metric.name: metric for metric in COMPARED_METRICS}
    for run, kept in zip(recorded.runs(), recorded.base(), strict=True):
        sums = kept.vehicles.columns().sum(axis=0, keepdims=True)
        error = run.result.tables["tracks"].query("judged and true_mode != 'stationary'")["heading_error_deg"].abs()
        unflipped = error[error <= 90.0]
        flipped = compared["track.heading_flip_rate"].value(sums)[0]
        assert flipped == pytest.approx(1 - len(unflipped) / len(error))
        mean = compared["track.heading_unflipped_mean_deg"].value(sums)[0]
        assert mean == pytest.approx(unflipped.mean(), rel=1e-5)
        if flipped == 0.0:  # then both means are equal
            assert mean == pytest.approx(run.result.metrics["track.heading_abs_mean_deg"].value, rel=1e-5)


def test_runs_are_pooled_as_trackeval_combines_sequences():
    need("dev", "trackeval")
    from trackeval.metrics import CLEAR, HOTA, Identity

    sequences = [
        tracking_sequence(*(run.result.tables[name] for name in ("truth", "tracks", "overlaps")))
        for run in recorded.runs()
    ]
    sums = np.vstack([kept.vehicles.columns() for kept in recorded.base()]).sum(axis=0, keepdims=True)
    values = {metric.name: metric.value(sums)[0] for metric in COMPARED_METRICS}
    for name, metric in {"HOTA": HOTA(), "MOTA": CLEAR(dict(LIMIT)), "IDF1": Identity(dict(LIMIT))}.items():
        combined = metric.combine_sequences({str(i): metric.eval_sequence(s) for i, s in enumerate(sequences)})
        assert values[f"track.{name.lower()}"] == pytest.approx(np.mean(combined[name]), abs=1e-9)


def test_metrics_without_observations_have_no_value():
    nothing = np.zeros((1, len(COLUMNS)))
    assert all(np.isnan(metric.value(nothing)[0]) for metric in COMPARED_METRICS)
