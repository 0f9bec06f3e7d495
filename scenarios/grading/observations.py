"""Observations of a run by kind: flat columns, made once from its tables, on which the metrics are computed.

Every kind has the columns `actor_id`, `class`, `actor`, and where they are known `range_m` [m], `view`, `points` and
`time_s` [s], by which its rows are filtered. Columns that only some metrics need are made when they are asked for.
"""

from collections.abc import Callable, Mapping
from functools import cached_property
from statistics import NormalDist
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading import clear_table, fit_errors, mma_metrics, track_metrics
from luxloop.scenarios.grading.articulated import angles_of
from luxloop.scenarios.grading.clear_table import HitStep, TrackingSequence, clear_hits, tracking_sequence
from luxloop.scenarios.grading.frame_tables import models_of, rows_by_actor, rows_of_pairs
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.occlusions import occlusion_table
from luxloop.scenarios.metrics.definition import BANDS, band
from luxloop.scenarios.metrics.definitions import (
    CANDIDATES,
    CORNER_FIGURES,
    COVERAGES,
    HORIZONS,
    LONG_M,
    NO_PAIR,
    NO_VEHICLE,
    SHORT_OCCLUSION_S,
    WITHIN_DEG,
)
from luxloop.scenarios.result import NOT_REPORTED, Metric
from luxloop.sim.sections import bend
from luxloop.tracker.records import MODELS

Column = npt.NDArray[Any]
Filters = Mapping[str, str]
NO_TRACE = f"{NOT_REPORTED} a trace of its stages"
NO_SEGMENT = "no segment belonged mostly to a graded vehicle"
ROUNDED_DEG = 0.5
"""Errors below this are zero in whole degrees [deg]."""
COLUMN_OF = {
    "range": "range_m",
    "points": "points",
    "time": "time_s",
    "class": "class",
    "view": "view",
    "actor": "actor",
}
"""Column that each filter applies to."""


class Observations:
    """Rows of one kind.

    Parameters
    ----------
    table
        A row per observation.
    why_none
        Reason of metrics without any row.
    make
        Functions that return a column that the table does not have, or None; the first column is taken.
    """

    def __init__(
        self, table: pd.DataFrame, why_none: str, *make: "Callable[[Observations, str], Column | None]"
    ) -> None:
        self.table = table
        self.why_none = why_none
        self._make = make
        self._columns: dict[str, Column] = {}
        self._masks: dict[tuple[tuple[str, str], ...], Bools] = {}

    def __len__(self) -> int:
        return len(self.table)

    def __getitem__(self, name: str) -> Column:
        """Return a column (n,), or NaN if there is none of this name."""
        if name not in self._columns:
            self._columns[name] = self._made(name)
        return self._columns[name]

    def _made(self, name: str) -> Column:
        if name in self.table:
            return np.asarray(self.table[name])
        for make in self._make:
            if (made := make(self, name)) is not None:
                return made
        return np.full(len(self), np.nan)

    @cached_property
    def vehicle(self) -> Ints:
        """(n,) number of the vehicle of each row, from 0 on."""
        return np.unique(self["actor_id"], return_inverse=True)[1]

    def chosen(self, filters: Filters) -> Bools:
        """(n,) mask of the rows with all these filters."""
        key = tuple(filters.items())
        if key not in self._masks:
            mask = np.ones(len(self), np.bool_)
            for one, value in key:
                mask &= self._of_filter(one, value)
            self._masks[key] = mask
        return self._masks[key]

    def _of_filter(self, key: str, value: str) -> Bools:
        """(n,) mask of one filter, which is made once."""
        one = ((key, value),)
        if one not in self._masks:
            self._masks[one] = matches(self[COLUMN_OF[key]], key, value)
        return self._masks[one]


def matches(column: Column, key: str, value: str) -> Bools:
    """(n,) mask of the rows whose column (n,) agrees with a filter."""
    if key in BANDS:
        low, high = band(value)
        return np.asarray((column >= low) & (column < high), np.bool_)
    return np.isin(column.astype(np.str_), value.split("|"))


class RunObservations:
    """Observations of a graded run, by kind.

    Parameters
    ----------
    tables
        Tables by name, as in `luxloop.scenarios.grading.frame_tables`.
    config
        Limits of grading. Those of single frames have no effect: the tables already contain theirs.
    frames
        Number of graded frames.
    """

    def __init__(self, tables: Mapping[str, pd.DataFrame], config: GradingConfig, frames: int) -> None:
        self.tables = tables
        self.config = config
        self.frames = frames
        self.given: dict[tuple[object, ...], dict[str, Metric]] = {}
        """Figures that are computed together for a kind, by kind and filters."""

    def of_kind(self, kind: str) -> Observations:
        """Return the observations of a kind."""
        found: Observations = getattr(self, kind)
        return found

    @cached_property
    def truth(self) -> pd.DataFrame:
        """The table `truth`."""
        return self.tables["truth"]

    @cached_property
    def tracks(self) -> pd.DataFrame:
        """The table `tracks`."""
        return self.tables["tracks"]

    @cached_property
    def traced(self) -> bool:
        """True if the tracker gave a trace of its stages: each of its frames has a row per cause."""
        return len(self.tables["outliers"]) > 0

    @cached_property
    def models(self) -> tuple[str, ...]:
        """Motion models of the filter bank."""
        return models_of(self.tracks)

    @cached_property
    def sequence(self) -> TrackingSequence:
        """Graded vehicles and counted tracks per frame."""
        return tracking_sequence(self.truth, self.tracks, self.tables["overlaps"])

    @cached_property
    def hits(self) -> list[HitStep]:
        """Hits of CLEAR."""
        return list(clear_hits(self.sequence, self.config.hit_iou_min))

    @cached_property
    def clear(self) -> clear_table.ClearTable:
        """Graded vehicles and counted tracks, row by row, with their hits."""
        return clear_table.clear_table(self.truth, self.tracks, self.sequence, self.hits)

    @cached_property
    def vehicle(self) -> Observations:
        """A row per graded vehicle and frame."""
        return Observations(self.clear.vehicles, NO_VEHICLE, self._of_vehicle, self._of_actor)

    @cached_property
    def traced_vehicle(self) -> Observations:
        """The observations of vehicles; none if the tracker gave no trace."""
        if self.traced:
            return self.vehicle
        return Observations(self.vehicle.table[:0], NO_TRACE, self._of_vehicle, self._of_actor)

    @cached_property
    def confirmation(self) -> Observations:
        """A row per vehicle, that of its first graded frame, with the time until its first hit."""
        return Observations(track_metrics.waits(self.clear), NO_VEHICLE, self._of_actor)

    @cached_property
    def fit(self) -> Observations:
        """A row per fitted rectangle of a graded vehicle."""
        fits = self.tables["fits"]
        fitted = fit_errors.with_regret(fits.loc[np.isfinite(fits["heading_error_deg"])])
        return Observations(fitted, NO_SEGMENT if self.traced else NO_TRACE, _of_fit, self._of_actor)

    @cached_property
    def track(self) -> Observations:
        """A row per confirmed track on a graded vehicle."""
        judged = self.tracks[self.tracks["judged"]]
        table = judged.reset_index(drop=True).assign(**track_metrics.measure(self.truth, judged))
        return Observations(table, NO_PAIR, self._of_track, self._of_actor)

    @cached_property
    def segment(self) -> Observations:
        """A row per segment with points of a graded vehicle."""
        segments = self.tables["segments"]
        merged = segments["second_share"].to_numpy() >= self.config.part_share_min
        return Observations(segments.assign(is_merged=merged), self._no_trace, self._of_actor)

    @cached_property
    def removal(self) -> Observations:
        """A row per cause of points and frame."""
        outliers = self.tables["outliers"]
        either = outliers["removed"] + outliers["clean_removed_beside"]
        return Observations(outliers.assign(removed_or_clean=either), NO_TRACE, _of_cause)

    @cached_property
    def occlusion(self) -> Observations:
        """A row per occlusion of a followed vehicle that is not longer than `memory_s`."""
        rows = self.tables.get("occlusions")
        if rows is None:  # files of boxes
            rows = occlusion_table(self.tables["truth"], self.tables["tracks"], self.config)
        rows = rows[rows["gap_s"] <= self.config.memory_s]
        short = rows["gap_s"].to_numpy() <= SHORT_OCCLUSION_S
        return Observations(rows.assign(short=short), "", self._of_actor)

    @cached_property
    def switch(self) -> Observations:
        """A row per change of the true mode of a followed vehicle."""
        found = mma_metrics.switch_latencies(self.track.table)
        rows = pd.DataFrame(found, columns=["actor_id", "latency_frames"])
        why = mma_metrics.NO_MODEL if self.tracks["model"].hasnans else ""
        return Observations(rows, why, self._of_actor)

    @cached_property
    def _no_trace(self) -> str:
        return NO_VEHICLE if self.traced else NO_TRACE

    def _of_actor(self, rows: Observations, name: str) -> Column | None:
        """(n,) class or name of the actor of each row."""
        if name not in ("class", "actor"):
            return None
        actors = self.truth[["actor_id", "kind", "name"]].drop_duplicates("actor_id").set_index("actor_id")
        column = actors["kind" if name == "class" else "name"].astype(object)
        return np.asarray(column.reindex(rows["actor_id"]), object)

    def _of_vehicle(self, rows: Observations, name: str) -> Column | None:
        table = rows.table
        if name == "missed":
            return np.asarray(~self.clear.is_hit, np.float64)
        if name == "is_hit":
            return self.clear.is_hit
        if name == "hit_iou":
            return clear_table.hit_overlaps(self.clear, self.sequence, self.hits)
        if name == "standing_since_seen":
            return self._standing_since_seen(table)
        if name == "long":
            return np.asarray(table["length_m"].to_numpy() > LONG_M)
        if name == "outside_largest_segment_share":
            return np.asarray(1.0 - table["largest_segment_share"].to_numpy(np.float64))
        if name == "time_without_hit_s":
            return _time_without_hit_s(table, self.clear.is_hit)
        if name == "segmented":
            return np.asarray(table["largest_segment_share"].notna())
        if name == "is_split":
            return np.asarray(table["segments"].to_numpy() >= 2)
        if name == "has_no_segment":
            return np.asarray(table["largest_segment_share"].to_numpy() <= 0.5)
        if name == "boxed":
            straight = bend(angles_of(table)) <= np.radians(self.config.bent_deg)
            return np.asarray(straight)
        return self._fitted(table) if name == "fitted" else None

    def _fitted(self, table: pd.DataFrame) -> Bools:
        """(n,) mask of the graded vehicles with a selected rectangle."""
        best = self.fit["best"].astype(np.bool_)
        chosen = (self.fit[name][best] for name in ("frame", "actor_id"))
        return rows_of_pairs(table["frame"].to_numpy(), table["actor_id"].to_numpy(), *chosen) >= 0

    def _of_track(self, rows: Observations, name: str) -> Column | None:
        if name in _OF_MOTION:
            return _OF_MOTION[name](rows)
        if name in ("stopped", "parked"):
            since_seen = self._standing_since_seen(rows.table)
            return np.asarray(rows["standing"].astype(np.bool_) & (since_seen == (name == "parked")))
        if name == "changing":
            return mma_metrics.around_changes(rows.table, self.truth)
        for label, seconds in HORIZONS.items():
            if name.endswith(f"_ahead_{label}_error_m"):
                estimate = name.removesuffix(f"_ahead_{label}_error_m")
                return mma_metrics.distance(rows.table, self._corner_ahead(seconds), estimate, label)
        return mma_metrics.corner_column(rows.table, name, self.config.nees_confidence)

    def _standing_since_seen(self, rows: pd.DataFrame) -> Bools:
        """(n,) mask of the rows of vehicles that have not moved since the first frame with a point on them."""
        starts = [self._first_motion.get(actor, np.inf) for actor in rows["actor_id"].tolist()]
        return np.asarray(rows["frame"].to_numpy() < np.array(starts), np.bool_)

    @cached_property
    def _first_motion(self) -> dict[int, int]:
        """First frame in which an actor moves in sight, by its id."""
        truth, found = self.truth, {}
        frame, is_seen = truth["frame"].to_numpy(), truth["points"].to_numpy() != 0
        moves = (truth["mode"] != MODELS[0]).to_numpy()
        in_time = np.argsort(frame, kind="stable")
        for actor, rows in rows_by_actor(truth["actor_id"].to_numpy(), in_time):
            moving = rows[moves[rows] & np.logical_or.accumulate(is_seen[rows])]
            if len(moving):
                found[actor] = int(frame[moving[0]])
        return found

    def _corner_ahead(self, seconds: float) -> Floats:
        """(K, 2) true positions of the tracked corners some time ahead [m], made once for all estimates."""
        if seconds not in self._corners:
            self._corners[seconds] = mma_metrics.true_corners(self.track.table, self.truth, seconds)
        return self._corners[seconds]

    @cached_property
    def _corners(self) -> dict[float, Floats]:
        return {}


_OF_MOTION: dict[str, Callable[[Observations], Column]] = {
    "any": lambda rows: np.ones(len(rows), np.bool_),
    "heading_abs_error_deg": lambda rows: np.abs(rows["heading_error_deg"]),
    "flipped": lambda rows: (np.abs(rows["heading_error_deg"]) > 90.0).astype(np.float64),
    "unflipped_heading_abs_error_deg": lambda rows: np.where(
        rows["flipped"] > 0.0, np.nan, np.abs(rows["heading_error_deg"])
    ),
    "heading_axis_abs_error_deg": lambda rows: np.abs(track_metrics.modulo_half_turn(rows["heading_error_deg"])),
    "speed_error_mps": lambda rows: rows["speed_mps"] - rows["true_speed_mps"],
    "speed_abs_error_mps": lambda rows: np.abs(rows["speed_error_mps"]),
    "length_abs_error_m": lambda rows: np.abs(rows["length_error_m"]),
    "width_abs_error_m": lambda rows: np.abs(rows["width_error_m"]),
    "height_abs_error_m": lambda rows: np.abs(rows["height_error_m"]),
}
"""Columns of the observations of tracks that follow from others."""


def _of_fit(rows: Observations, name: str) -> Column | None:
    error = rows["heading_error_deg"]
    if name in CANDIDATES:
        return np.asarray(rows.table["method"] == name)
    if name == "heading_abs_error_deg":
        return np.abs(error)
    if name == "rounds_to_0":
        return np.abs(error) < ROUNDED_DEG
    for limit in WITHIN_DEG:
        if name == f"within_{limit}deg":
            return np.abs(error) <= limit
    for figure in CORNER_FIGURES:
        if name == f"{figure}_abs_error_m":
            return np.abs(rows[f"{figure}_error_m"])
    for percent in COVERAGES:
        if name == f"inside_{percent}":
            margin = NormalDist().inv_cdf(0.5 + 0.005 * percent) * rows["box_heading_std_deg"]
            excess = np.abs(rows["box_heading_error_deg"]) - margin
            return np.where(np.isnan(excess), np.nan, excess <= 0.0)
    if name == "at_bound_deg":  # the mean absolute value of a normal error is sqrt(2 / pi) times its deviation
        return np.asarray(np.sqrt(2.0 / np.pi) * rows["heading_bound_deg"])
    return np.where(np.isnan(rows["heading_bound_deg"]), np.nan, np.abs(error)) if name == "bounded_abs_deg" else None


def _of_cause(rows: Observations, name: str) -> Column | None:
    return np.asarray(rows.table["cause"] == name)


def _time_without_hit_s(vehicles: pd.DataFrame, is_hit: Bools) -> Floats:
    """(n,) time since the last hit of each graded row's vehicle, or since its first graded frame without one [s]."""
    ordered = vehicles.assign(hit_s=vehicles["time_s"].where(is_hit)).sort_values("frame", kind="stable")
    last_s = ordered.groupby("actor_id")["hit_s"].ffill()
    first_s = ordered.groupby("actor_id")["time_s"].transform("min")
    waited_s: pd.Series = ordered["time_s"] - last_s.fillna(first_s)
    return np.asarray(waited_s.reindex(vehicles.index), np.float64)
