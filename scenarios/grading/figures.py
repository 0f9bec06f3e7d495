"""Figures of a run: each metric computed from its definition when it is asked for."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import NamedTuple

import numpy as np

from luxloop.scenarios.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading import given_figures
from luxloop.scenarios.grading.metric_sheet import why_no_interval
from luxloop.scenarios.grading.observations import Observations, RunObservations
from luxloop.scenarios.metrics.definition import Selection, with_filters
from luxloop.scenarios.metrics.definitions import OF_LOOP, find_metric, standard_names
from luxloop.scenarios.metrics.own_metric import PREFIX
from luxloop.scenarios.result import Metric
from luxloop.scenarios.statistics.jackknife import ratio_interval, std_interval
from luxloop.tracker.records import BASELINES

NO_MODEL = "the run's filter bank has no such model"
NO_BASELINES = "the tracker fitted no baselines: [tracker.baselines] enabled = true"
NO_SUCH = "the run has no such metric; run the scenario again"


class Figures(Mapping[str, Metric]):
    """Metrics by name, computed when they are asked for. Iteration yields those that every result holds.

    Parameters
    ----------
    run
        Observations of the run.
    known
        Figures that are known already, such as those of the run loop, of a file, and own metrics.
    why_not
        Function that returns why a metric does not apply to this run; empty if it does.
    names
        Names that iteration yields besides the known ones; those of all results if left out.
    """

    def __init__(
        self,
        run: RunObservations,
        known: Mapping[str, Metric] | None = None,
        why_not: Callable[[Selection], str] | None = None,
        names: Iterable[str] | None = None,
    ) -> None:
        self.run = run
        self._known = dict(known or {})
        self._computed: dict[str, Metric] = {}
        self._why_not = why_not
        self._names = names

    def __getitem__(self, name: str) -> Metric:
        if name in self._known:
            return self._known[name]
        if name not in self._computed:
            try:
                selection = find_metric(name)
            except ValueError as error:
                raise KeyError(f"{name}: {error}") from error
            if selection.name != name:
                return self[selection.name]
            self._computed[name] = self._figure(selection)
        return self._computed[name]

    def __iter__(self) -> Iterator[str]:
        names = standard_names() if self._names is None else self._names
        graded = (name for name in names if self._has(find_metric(name)))
        yield from dict.fromkeys([*graded, *self._known])

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __or__(self, others: Mapping[str, Metric]) -> "Figures":
        """Return these figures with others, which replace those of the same names."""
        return Figures(self.run, {**self._known, **others}, self._why_not, self._names)

    def __repr__(self) -> str:
        return f"Figures({len(self)} metrics)"

    def where(self, name: str, **filters: str) -> Metric:
        """Return a metric with filters of any values: the classes of boxes in files have other names than actors'."""
        selection = with_filters(find_metric(name), {key.rstrip("_"): value for key, value in filters.items()})
        if selection.name not in self._known and selection.name not in self._computed:
            self._computed[selection.name] = self._figure(selection)
        return self[selection.name]

    def asked(self, names: Iterable[str]) -> "Figures":
        """Return these figures, with further names among those that the result holds."""
        return self | {name: self[name] for name in names if not name.startswith(PREFIX)}

    def _has(self, selection: Selection) -> bool:
        """Return False for the metrics of the run loop, and of models and columns that the run does not have."""
        definition, model = selection.definition, selection.parameters.get("model", "mma")
        has_column = not definition.needs or definition.needs in self.run.tracks
        return definition.kind not in OF_LOOP and has_column and model in ("mma", *self.run.models)

    def _figure(self, selection: Selection) -> Metric:
        why = self._why_not(selection) if self._why_not else ""
        return Metric(None, selection.unit, 0, why) if why else figure(selection, self.run)


def figure(selection: Selection, run: RunObservations) -> Metric:
    """Return a metric of a run."""
    definition = selection.definition
    if definition.kind in OF_LOOP:
        return Metric(None, definition.unit, 0, NO_SUCH)
    if selection.parameters.get("model", "mma") not in ("mma", *run.models):
        return Metric(None, definition.unit, 0, NO_MODEL)
    if definition.statistic == "given":
        return given_figures.figure(selection, run)
    return of_rows(selection, run.of_kind(definition.kind))


class Counted(NamedTuple):
    """Observations that a metric counts."""

    row: Ints
    """(n,) rows of its kind."""
    value: Floats
    """(n,)."""
    weight: Floats
    """(n,) denominators."""


def counted(selection: Selection, observations: Observations) -> Counted:
    """Return the observations of a kind that a metric counts: those of its rows and filters whose value is known."""
    definition = selection.definition
    rows = rows_of(selection, observations)
    value = observations[selection.column(definition.value)][rows].astype(np.float64)
    known = ~np.isnan(value) if definition.statistic in ORDERED else np.isfinite(value)
    used = np.flatnonzero(rows)[known]
    weight = observations[definition.weight][used].astype(np.float64) if definition.weight else np.ones(len(used))
    return Counted(used, value[known], weight)


def rows_of(selection: Selection, observations: Observations) -> Bools:
    """(n,) mask of the observations of a kind that a metric is about, with known and unknown values."""
    rows = observations.chosen(selection.filters)
    if selection.definition.rows:
        rows = rows & observations[selection.column(selection.definition.rows)].astype(np.bool_)
    return rows


def of_rows(selection: Selection, observations: Observations) -> Metric:
    """Return a metric computed over the rows of its kind."""
    definition = selection.definition
    used, value, weight = counted(selection, observations)
    n = int(weight.sum()) if definition.statistic == "rate" else len(used)
    number = _number(definition.statistic, value, weight) if n else None
    if number is None or not math.isfinite(number):
        return Metric(None, definition.unit, n, _why_none(selection, observations, rows_of(selection, observations)))
    if not definition.interval:
        return Metric(number, definition.unit, n)
    vehicle = observations.vehicle[used]
    if definition.statistic == "std":
        interval = std_interval(vehicle, value, definition.range)
    else:
        interval = ratio_interval(vehicle, value, weight, definition.range)
    why = "" if interval else why_no_interval(number)
    return Metric(number, definition.unit, n, interval=interval, why_no_interval=why)


ORDERED = ("median", "order_median", "order_p90")
"""Statistics to which infinite values count."""


def _number(statistic: str, value: Floats, weight: Floats) -> float:
    """Return a statistic of values (n,) with denominators (n,), n > 0; infinite if too many are censored."""
    if statistic in ("mean", "rate"):
        return float(value.sum() / weight.sum())
    if statistic == "std":
        return float(np.std(value))
    if statistic == "median":
        return float(np.median(value))
    if statistic == "p90":
        return float(np.quantile(value, 0.9))
    return float(np.quantile(value, 0.5 if statistic == "order_median" else 0.9, method="inverted_cdf"))


def _why_none(selection: Selection, observations: Observations, rows: Bools) -> str:
    """Return the reason of a missing value; `rows` (n,) are those that would count."""
    definition = selection.definition
    of_kind = observations.why_none or definition.why_none
    if not len(observations):
        return of_kind
    if rows.any() and definition.statistic == "rate":
        return f"{definition.why_unknown}, with {selection.chosen}"
    if rows.any():
        return definition.why_unknown or definition.why_none or of_kind
    if selection.filters and not observations.chosen(selection.filters).any():
        return f"no observation has {selection.chosen}"
    if selection.parameters.get("method") in BASELINES:
        return NO_BASELINES
    why = definition.why_none or of_kind
    return f"{why}, with {selection.chosen}" if selection.chosen else why
