"""Values of the metrics of a scenario file: shipped metrics over some actors, and functions of the run's tables.

They are computed after the run, from its tables, so the trace hash does not depend on them.
"""

import importlib
import math
import sys
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from luxloop import former_names
from luxloop.scenarios.errors import MetricError
from luxloop.scenarios.grading import grader
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.own_metric import OwnMetric
from luxloop.scenarios.result import Metric
from luxloop.scenarios.run.device import place_of
from luxloop.sensor_model.truth import NO_ACTOR

Tables = Mapping[str, pd.DataFrame]
MetricFunction = Callable[[dict[str, pd.DataFrame]], float | None]
"""A function of the user: from tables by name, as in `scenarios.grading.frame_tables`, to a number, or None if the
metric does not apply."""

OF_ACTORS = ("tracks", "overlaps", "fits", "segments", "emergence", "occlusions", "blockers")
"""Tables of which the rows of other actors are left out."""


def load(metrics: Iterable[OwnMetric]) -> dict[str, MetricFunction]:
    """Import the functions of metrics, by the name of the metric.

    Raises
    ------
    MetricError
        A module cannot be imported, or has no such function.
    """
    return {metric.name: _load(metric) for metric in metrics if metric.function}


def grade(metrics: Iterable[OwnMetric], tables: Tables, config: GradingConfig, frames: int) -> dict[str, Metric]:
    """Return the metrics by name, from the tables of a run of some frames.

    Raises
    ------
    MetricError
        A function cannot be imported, fails, or returns something other than a number.
    """
    found, functions = {}, load(chosen := list(metrics))
    for metric in chosen:
        if metric.function:
            found[metric.name] = _call(functions[metric.name], metric, tables, frames)
        else:
            found[metric.name] = _over_actors(metric, tables, config, frames)
    return found


def tables_of(tables: Tables, actors: list[str], classes: list[str]) -> dict[str, pd.DataFrame]:
    """Return the tables with only some actors graded, and without tracks on others or on nothing.

    Parameters
    ----------
    actors, classes
        Names and classes of the actors; an empty list chooses all.
    """
    truth = tables["truth"]
    chosen = pd.Series(True, truth.index)
    if actors:
        chosen &= truth["name"].isin(actors)
    if classes:
        chosen &= truth["kind"].astype(str).isin(classes)
    ids = set(truth.loc[chosen, "actor_id"]) - {NO_ACTOR}
    kept = {name: tables[name][tables[name]["actor_id"].isin(ids)] for name in OF_ACTORS if name in tables}
    return {**tables, **kept, "truth": truth.assign(graded=truth["graded"] & chosen)}


def _over_actors(metric: OwnMetric, tables: Tables, config: GradingConfig, frames: int) -> Metric:
    of = tables_of(tables, metric.actors, metric.classes)
    names, kinds = set(tables["truth"]["name"]), set(tables["truth"]["kind"].astype(str))
    unit = metric.definition.unit
    if unknown := [name for name in metric.actors if name not in names]:
        return Metric(None, unit, 0, f'no actor is named "{unknown[0]}"')
    if metric.classes and not kinds & set(metric.classes):
        return Metric(None, unit, 0, f"no actor of class {' or '.join(metric.classes)}")
    graded = grader.grade(of, config, frames)
    return graded.get(metric.of) or Metric(None, unit, 0, "the run's filter bank has no such model")


def _call(function: MetricFunction, metric: OwnMetric, tables: Tables, frames: int) -> Metric:
    try:
        value: Any = function({name: table.copy() for name, table in tables.items()})
    except (Exception, SystemExit) as error:
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        raise MetricError(f"{metric.name}: {metric.function}: {place_of(error, (__file__,))}{reason}") from error
    if value is None:
        return Metric(None, metric.definition.unit, 0, f"{metric.function} returned no value")
    try:
        number = float(value)
    except (TypeError, ValueError) as error:
        raise MetricError(f"{metric.name}: {metric.function} returned a {type(value).__name__}, no number") from error
    if not math.isfinite(number):
        raise MetricError(f"{metric.name}: {metric.function} returned {number}; return None without a value")
    return Metric(number, metric.definition.unit, frames)


def _load(metric: OwnMetric) -> MetricFunction:
    module, _, name = metric.function.partition(":")
    if (here := str(Path.cwd())) not in sys.path:
        sys.path.append(here)  # after installed packages, as for --tracker
    try:
        function: Any = getattr(importlib.import_module(module), name)
    except (Exception, SystemExit) as error:
        reason = " ".join(f"{type(error).__name__}: {error}".split()) + former_names.remedy(error, module)
        raise MetricError(
            f"{metric.name}: function = {metric.function}: {reason}; name a module on the Python path or in {here}, "
            "and a function in it"
        ) from error
    if not callable(function):
        raise MetricError(f"{metric.name}: function = {metric.function}: {name} cannot be called; name a function")
    return function  # type: ignore[no-any-return]
