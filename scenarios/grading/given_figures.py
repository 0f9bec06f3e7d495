"""Figures that are computed together for a whole kind: matched tracks, GOSPA, emergence, events, people and riders."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Bools
from luxloop.scenarios.grading import (
    distance_matching,
    emergence,
    gospa,
    mma_metrics,
    track_metrics,
    vulnerable_metrics,
)
from luxloop.scenarios.grading.metric_sheet import MetricSheet
from luxloop.scenarios.grading.observations import COLUMN_OF, Filters, RunObservations, matches
from luxloop.scenarios.grading.truth_events import truth_event
from luxloop.scenarios.metrics.definition import Selection
from luxloop.scenarios.metrics.definitions import NO_VEHICLE, TARGETS
from luxloop.scenarios.result import Metric
from luxloop.sensor_model.truth import NO_ACTOR

NO_FRAME = "there was no frame"
OF_ACTORS = ("overlaps", "fits", "segments", "emergence", "occlusions", "blockers")
"""Tables of which the rows of other actors are left out."""


def figure(selection: Selection, run: RunObservations) -> Metric:
    """Return a figure of a kind that is computed as a whole, once for each set of filters."""
    kind = KINDS[selection.definition.kind]
    key = (kind, *selection.filters.items())
    if key not in run.given:
        run.given[key] = kind(run, selection.filters)
    metric = run.given[key][Selection(selection.definition, selection.parameters).name]
    if metric.value is None and selection.filters and figure(replace(selection, filters={}), run).value is not None:
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
    sheet = MetricSheet()
    for target in ("any", *TARGETS):
        rows = run.track.chosen(filters) & run.track[target].astype(np.bool_)
        name = "mma.gain" if target == "any" else f"mma.gain{{target={target}}}"
        mma_metrics.grade_gain(sheet, run.track.table[rows], name, run.models)
    return sheet.metrics


def _scores(run: RunObservations, filters: Filters) -> dict[str, Metric]:
    """Return the figures of matched tracks."""
    sheet = MetricSheet()
    track_metrics.grade(sheet, restricted(run, filters) if filters else run)
    return sheet.metrics


def _gospa(run: RunObservations, filters: Filters) -> dict[str, Metric]:
    """Return GOSPA and its parts. False tracks have a range and a time, but no class and no view."""
    false = _could_be_chosen(run.clear.tracks, filters)
    ranged = "range" not in filters or bool(run.clear.tracks["range_m"].notna().all())
    sheet = MetricSheet()
    gospa.grade_gospa(sheet, run.clear, run.config.gospa_cutoff_m, run.vehicle.chosen(filters), false, ranged=ranged)
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
    emergence.grade_emergence(sheet, run.tables.get("emergence"), run.config.target)
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
    on_chosen = _keys(tracks).isin(keys)
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


def _keys(rows: pd.DataFrame) -> pd.MultiIndex:
    return pd.MultiIndex.from_frame(rows[["frame", "actor_id"]])
