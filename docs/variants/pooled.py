"""Runs of several seeds, graded as one: metrics and intervals over all their vehicles."""

from collections.abc import Sequence
from typing import NamedTuple

import pandas as pd

from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.grading import dataset_statistics, fit_metrics, frame_tables, mma_metrics
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.metric_sheet import MetricSheet
from luxloop.scenarios.result import Metric, Result

TABLES = ("truth", "fits", "tracks")
WHY_NONE = "no observation"


class Pooled(NamedTuple):
    """Metrics of some runs of one tracker."""

    drives: int
    models: tuple[str, ...]
    """Motion models of the tracker."""
    metrics: dict[str, Metric]
    """Metrics of the data set, fits and positions, over all runs."""


def pooled(results: Sequence[Result]) -> Pooled:
    """Grade the tables of runs together.

    Vehicles of different runs are different vehicles. Intervals resample them as in `scenarios.grading.bootstrap`: each
    resample has as many vehicles as all runs together, from any run. They therefore contain the spread between seeds.

    Raises
    ------
    OutputError
        A run has no table that is needed.
    """
    table = {name: _joined(results, name) for name in TABLES}
    observations = table["truth"][table["truth"]["graded"]]
    models = frame_tables.models_of(table["tracks"])
    sheet = MetricSheet()
    dataset_statistics.grade(sheet, observations, sum(result.frames for result in results))
    fit_metrics.grade(sheet, table["fits"], len(observations), WHY_NONE)
    confidence = GradingConfig(**results[0].config["grading"]).nees_confidence
    mma_metrics.grade(sheet, table["tracks"], confidence, models)
    return Pooled(len(results), tuple(models), sheet.metrics)


def _joined(results: Sequence[Result], name: str) -> pd.DataFrame:
    """Return a table of all runs, with ids of actors that are unique among them."""
    parts, first = [], 0
    for result in results:
        if name not in result.tables:
            raise OutputError(f"run of {result.scenario}, seed {result.seed}: no table {name}; run the scenario again")
        part, actor = result.tables[name], result.tables[name]["actor_id"]
        parts.append(part.assign(actor_id=actor.where(actor < 0, actor + first)))  # below 0: no actor
        first += 1 + int(result.tables["truth"]["actor_id"].max())
    return pd.concat(parts, ignore_index=True)
