"""Runs of several seeds, graded as one: metrics and intervals over all their vehicles."""

from collections.abc import Sequence
from typing import NamedTuple

import pandas as pd

from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.grading.figures import Figures
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.observations import RunObservations
from luxloop.scenarios.result import Result

TABLES = ("truth", "fits", "tracks", "overlaps", "outliers")


class Pooled(NamedTuple):
    """Metrics of some runs of one tracker."""

    drives: int
    models: tuple[str, ...]
    """Motion models of the tracker."""
    metrics: Figures
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
    tables = {name: _joined(results, name) for name in TABLES}
    config = GradingConfig(**results[0].config["grading"])
    run = RunObservations(tables, config, sum(result.frames for result in results))
    return Pooled(len(results), run.models, Figures(run))


def _joined(results: Sequence[Result], name: str) -> pd.DataFrame:
    """Return a table of all runs, with numbers of frames, actors and tracks that are unique among them."""
    parts, first = [], dict.fromkeys(("frame", "actor_id", "track_id"), 0)
    for result in results:
        if name not in result.tables:
            raise OutputError(f"run of {result.scenario}, seed {result.seed}: no table {name}; run the scenario again")
        part = result.tables[name]
        ids = {key: part[key].where(part[key] < 0, part[key] + first[key]) for key in first if key in part}
        parts.append(part.assign(**ids))  # below 0: no actor, no track
        for key, table in (("frame", "truth"), ("actor_id", "truth"), ("track_id", "tracks")):
            first[key] += 1 + int(result.tables[table][key].max())
    return pd.concat(parts, ignore_index=True)
