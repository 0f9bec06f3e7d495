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
from luxloop.scenarios.metrics.own_metric import OwnMetric
from luxloop.scenarios.result import Metric
from luxloop.scenarios.run.device import place_of

Tables = Mapping[str, pd.DataFrame]
MetricFunction = Callable[[dict[str, pd.DataFrame]], float | None]
"""A function of the user: from tables by name, as in `scenarios.grading.frame_tables`, to a number, or None if the
metric does not apply."""


def load(metrics: Iterable[OwnMetric]) -> dict[str, MetricFunction]:
    """Import the functions of metrics, by the name of the metric.

    Raises
    ------
    MetricError
        A module cannot be imported, or has no such function.
    """
    return {metric.name: _load(metric) for metric in metrics if metric.function}


def grade(
    metrics: Iterable[OwnMetric], tables: Tables, figures: Mapping[str, Metric], frames: int
) -> dict[str, Metric]:
    """Return the metrics by name, from the tables and the figures of a run of some frames.

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
            found[metric.name] = _over_actors(metric, tables, figures)
    return found


def _over_actors(metric: OwnMetric, tables: Tables, figures: Mapping[str, Metric]) -> Metric:
    names, kinds = set(tables["truth"]["name"]), set(tables["truth"]["kind"].astype(str))
    unit = metric.definition.unit
    if unknown := [name for name in metric.actors if name not in names]:
        return Metric(None, unit, 0, f'no actor is named "{unknown[0]}"')
    if metric.classes and not kinds & set(metric.classes):
        return Metric(None, unit, 0, f"no actor of class {' or '.join(metric.classes)}")
    return figures[metric.selection.name]


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
