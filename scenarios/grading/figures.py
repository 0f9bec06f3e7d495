"""Figures of a run: each metric computed from its definition when it is asked for."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pandas as pd

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading import (
    distance_matching,
    emergence,
    gospa,
    mma_metrics,
    track_metrics,
    vulnerable_metrics,
)
from luxloop.scenarios.grading.metric_sheet import MetricSheet, why_no_interval
from luxloop.scenarios.grading.observations import COLUMN_OF, Filters, Observations, RunObservations, matches
from luxloop.scenarios.grading.truth_events import truth_event
from luxloop.scenarios.metrics.definition import Selection, with_filters
from luxloop.scenarios.metrics.definitions import NO_VEHICLE, OF_LOOP, TARGETS, find_metric, standard_names
from luxloop.scenarios.metrics.own_metric import PREFIX
from luxloop.scenarios.result import Metric
from luxloop.scenarios.statistics.jackknife import ratio_interval, std_interval
from luxloop.sensor_model.truth import NO_ACTOR
from luxloop.tracker.records import BASELINES

NO_FRAME = "there was no frame"
OF_ACTORS = ("overlaps", "fits", "segments", "emergence", "occlusions", "blockers")
"""Tables of which the rows of other actors are left out."""


def _given(selection: Selection, run: RunObservations) -> Metric:
    """Return a figure of a kind that is computed as a whole, once for each set of filters."""
    kind = KINDS[selection.definition.kind]
    key = (kind, *selection.filters.items())
    if key not in run.given:
        run.given[key] = kind(run, selection.filters)
    metric = run.given[key][Selection(selection.definition, selection.parameters).name]
    if metric.value is None and selection.filters and _given(replace(selection, filters={}), run).value is not None:
        return replace(metric, reason=f"{metric.reason}, with {selection.chosen}")
    return metric


def _dataset(run: RunObservations, filters: Filters) -> dict[str, Metric]:
    """Return the figures of the graded data set, as in the paper's table I. They do not depend on the tracker."""
    every = run.vehicle
    rows = every.table[every.chosen(filters)] if filters else every.table
    count, vehicles, frames = len(rows), int(rows["actor_id"].nunique()), run.frames
    sheet = MetricSheet()
    for name, value in (("vehicles", vehicles), ("observations", count), ("frames", frames)):
        sheet.write(f"dataset.{name}", value, frames, NO_FRAME)
    sheet.rate("dataset.share", count, len(every), NO_VEHICLE)
    sheet.rate("dataset.observations_per_vehicle", count, vehicles, NO_VEHICLE)
    sheet.rate("dataset.observations_per_frame", count, frames, NO_FRAME)
    sheet.mean("dataset.points_per_observation", rows["points"].to_numpy(np.float64), NO_VEHICLE)
    return sheet.metrics


def _gain(run: RunObservations, filters: Filters) -> dict[str, Metric]:
    """Return the gain of model selection, by the motion of the vehicles."""
    sheet, off = MetricSheet(), mma_metrics.corner_distances(run.track.table, run.models)
    for target in ("any", *TARGETS):
        rows = run.track.chosen(filters) & run.track[target].astype(np.bool_)
        name = "mma.gain" if target == "any" else f"mma.gain{{target={target}}}"
        mma_metrics.grade_gain(sheet, off[rows], name)
    return sheet.metrics


def _scores(run: RunObservations, filters: Filters) -> dict[str, Metric]:
    """Return the figures of matched tracks."""
    sheet = MetricSheet()
    track_metrics.grade(sheet, restricted(run, filters) if filters else run)
    return sheet.metrics


def _gospa(run: RunObservations, filters: Filters) -> dict[str, Metric]:
    """Return GOSPA and its parts. False tracks have a range and a time, but no class and no view."""
    false = _could_be_chosen(run.clear.tracks, filters)
    sheet = MetricSheet()
    gospa.grade_gospa(sheet, run.clear, run.config.gospa_cutoff_m, run.vehicle.chosen(filters), false)
    return sheet.metrics


def _recall(run: RunObservations, filters: Filters) -> dict[str, Metric]:
    """Return the averages over recalls."""
    sheet = MetricSheet()
    distance_matching.grade(sheet, run.clear, run.config.match_distance_m, filters)
    return sheet.metrics


def _could_be_chosen(tracks: pd.DataFrame, filters: Filters) -> Bools:
    """(n,) mask of the tracks that have these filters if they are on nothing, where only range and time are known."""
    known = {"range", "time"}
    chosen = np.full(len(tracks), not set(filters) - known)
    for key in set(filters) & known:
        chosen &= matches(tracks[COLUMN_OF[key]].to_numpy(), key, filters[key])
    return chosen


def _emergence(run: RunObservations, filters: Filters) -> dict[str, Metric]:
    del filters  # emergence has none
    sheet = MetricSheet()
    emergence.grade_emergence(sheet, run.tables["emergence"], run.config.target)
    return sheet.metrics


def _events(run: RunObservations, filters: Filters) -> dict[str, Metric]:
    del filters  # events have none
    sheet = MetricSheet()
    truth_event.grade_events(sheet, run.tables.get("events"), run.tables.get("extremes"))
    return sheet.metrics


def _vulnerable(run: RunObservations, filters: Filters) -> dict[str, Metric]:
    sheet = MetricSheet()
    vulnerable_metrics.grade_vulnerable(sheet, run.truth, run.tracks, run.tables["overlaps"], run.config, filters)
    return sheet.metrics


KINDS: Mapping[str, Callable[[RunObservations, Filters], dict[str, Metric]]] = {
    "dataset": _dataset,
    "gain": _gain,
    "score": _scores,
    "gospa": _gospa,
    "recall": _recall,
    "emergence": _emergence,
    "event": _events,
    "people": _vulnerable,
    "riders": _vulnerable,
}


def restricted(run: RunObservations, filters: Filters) -> RunObservations:
    """Return a run in which only the vehicles with these filters are graded.

    Tracks on other vehicles are left out. False tracks are kept by range and time; with a filter for class, view or
    actor there are none, since a track on nothing has neither.
    """
    truth, tracks = run.truth, run.tracks
    graded = np.zeros(len(truth), np.bool_)
    graded[np.flatnonzero(truth["graded"].to_numpy())] = run.vehicle.chosen(filters)
    keys = pd.MultiIndex.from_frame(truth.loc[graded, ["frame", "actor_id"]])
    on_chosen = pd.MultiIndex.from_frame(tracks[["frame", "actor_id"]]).isin(keys)
    false = (tracks["verdict"] == "false").to_numpy() & _could_be_chosen(tracks, filters)
    kept: Bools = np.asarray(on_chosen | false)
    tables = {**run.tables, "truth": truth.assign(graded=graded), "tracks": tracks[kept]}
    if {"class", "actor"} & set(filters):
        chosen = np.ones(len(truth), np.bool_)
        for key in {"class", "actor"} & set(filters):
            chosen &= matches(truth["kind" if key == "class" else "name"].to_numpy(object), key, filters[key])
        ids = set(truth.loc[chosen, "actor_id"]) - {NO_ACTOR}
        tables |= {name: tables[name][tables[name]["actor_id"].isin(ids)] for name in OF_ACTORS if name in tables}
    return RunObservations(tables, run.config, run.frames)


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
        return _given(selection, run)
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
