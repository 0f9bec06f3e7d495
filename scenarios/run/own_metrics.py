"""Values of the metrics of a scenario file: shipped metrics over some actors, and functions of the run's tables.

They are computed after the run, from its tables, so the trace hash does not depend on them. Functions are code of the
user: they run in a process of their own, with a time limit.
"""

import math
import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from luxloop.scenarios.errors import MetricError
from luxloop.scenarios.metrics.own_metric import OwnMetric
from luxloop.scenarios.result import Metric
from luxloop.scenarios.run import child_process, user_code
from luxloop.scenarios.run.child_process import ChildError, ChildTimeoutError

Tables = Mapping[str, pd.DataFrame]
"""Tables by name, as in `scenarios.grading.frame_tables`; a function makes a number of them, or None if the metric does
not apply."""
LIMIT_S = 60.0
"""Time limit of all functions of a run [s]."""
ANSWER_MAX = 1 << 20
"""Longest answer [bytes]."""


def load(metrics: Iterable[OwnMetric]) -> None:
    """Check that the functions of metrics can be imported.

    Raises
    ------
    MetricError
        A module cannot be imported, or has no such function.
    """
    _answers(list(metrics), None)


def grade(
    metrics: Iterable[OwnMetric], tables: Tables, figures: Mapping[str, Metric], frames: int
) -> dict[str, Metric]:
    """Return the metrics by name, from the tables and the figures of a run of some frames.

    Raises
    ------
    MetricError
        A function cannot be imported, fails, takes too long, or returns something other than a number.
    """
    answers = _answers(chosen := list(metrics), tables)
    return {
        metric.name: _value(answers[metric.name], metric, frames)
        if metric.function
        else _over_actors(metric, tables, figures)
        for metric in chosen
    }


def _over_actors(metric: OwnMetric, tables: Tables, figures: Mapping[str, Metric]) -> Metric:
    names, kinds = set(tables["truth"]["name"]), set(tables["truth"]["kind"].astype(str))
    unit = metric.definition.unit
    if unknown := [name for name in metric.actors if name not in names]:
        return Metric(None, unit, 0, f'no actor is named "{unknown[0]}"')
    if metric.classes and not kinds & set(metric.classes):
        return Metric(None, unit, 0, f"no actor of class {' or '.join(metric.classes)}")
    return figures[metric.selection.name]


def _answers(metrics: list[OwnMetric], tables: Tables | None) -> dict[str, dict[str, Any]]:
    """Return the answers of the process of functions, by the name of the metric."""
    functions = {metric.name: metric.function for metric in metrics if metric.function}
    if not functions:
        return {}
    deadline = time.monotonic() + LIMIT_S
    request = (functions, str(Path.cwd()), tables and dict(tables))
    listed = f"functions {', '.join(functions.values())}"
    try:
        answers = child_process.ask(__name__, request, ANSWER_MAX, deadline)
        for metric in metrics:
            if metric.function and "not_loaded" in answers[metric.name]:
                reason = answers[metric.name]["not_loaded"]
                raise MetricError(f"{metric.name}: function = {metric.function}: {reason}")
        return {name: dict(answers[name]) for name in functions}
    except ChildTimeoutError as error:
        raise MetricError(f"{listed}: took more than {LIMIT_S:g} s") from error
    except (ChildError, ValueError, KeyError, TypeError) as error:
        raise MetricError(f"{listed}: their process {error}") from error


def _value(answer: Mapping[str, Any], metric: OwnMetric, frames: int) -> Metric:
    """Return the metric of an answer."""
    if "error" in answer:
        raise MetricError(f"{metric.name}: {metric.function}: {answer['error']}")
    if "type" in answer:
        raise MetricError(f"{metric.name}: {metric.function} returned a {answer['type']}, no number")
    value = answer.get("value")
    if value is None:
        return Metric(None, metric.definition.unit, 0, f"{metric.function} returned no value")
    if not isinstance(value, float):
        raise MetricError(f"{metric.name}: the process of {metric.function} answered no number")
    if not math.isfinite(value):
        raise MetricError(f"{metric.name}: {metric.function} returned {value}; return None without a value")
    return Metric(value, metric.definition.unit, frames)


def serve() -> None:
    """Answer the request."""
    child_process.answer(values)


def values(request: tuple[dict[str, str], str, dict[str, Any] | None]) -> dict[str, dict[str, Any]]:
    """Return the answer to a request."""
    functions, folder, tables = request
    return {name: _answer(function, Path(folder), tables) for name, function in functions.items()}


def _answer(function: str, folder: Path, tables: dict[str, Any] | None) -> dict[str, Any]:
    """Return the value of a function, or why there is none."""
    try:
        called = user_code.load(function, folder, "name a function")
    except user_code.UserCodeError as error:
        return {"not_loaded": str(error)}
    if tables is None:
        return {}
    try:
        value: Any = called({name: table.copy() for name, table in tables.items()})
    except BaseException as error:  # all that the user's code can raise
        return {"error": f"{user_code.place_of(error, (__file__,))}{user_code.reason_of(error)}"}
    try:
        if not isinstance(value, str | bytes):  # of which float() reads numbers
            return {"value": None if value is None else float(value)}
    except BaseException:  # its class may do anything
        pass
    return {"type": type(value).__name__}
