"""Frames in which a metric is worst, as starting points of an analysis."""

from collections.abc import Mapping
from typing import NamedTuple

import pandas as pd

from luxloop.scenarios.grading import frame_badness, track_badness
from luxloop.scenarios.grading.frame_badness import RatedRows
from luxloop.scenarios.grading.track_badness import ESTIMATES
from luxloop.scenarios.metrics.definitions import DRIVERS, find_metric
from luxloop.scenarios.metrics.own_metric import PREFIX
from luxloop.scenarios.result import Result
from luxloop.sensor_model.truth import NO_ACTOR

IDENTITIES = ("id_switches", "id_switches_in_view", "fragments", "occlusion_survival", "hidden_2s_survival")
"""Metrics `track.*` about identities; they are bad where a vehicle goes from one track to another."""
MODES = ("mode_accuracy", "stationary_accuracy", "selected", "switch_latency_frames")
"""Metrics `mma.*` about the selected model."""


class WorstFrame(NamedTuple):
    """A frame to look at, and a description of the error in it."""

    frame: int
    time_s: float
    what: str
    actor_id: int = NO_ACTOR
    """The vehicle with the error; `NO_ACTOR` if the error is not that of one vehicle."""

    def __str__(self) -> str:
        return f"frame {self.frame} ({self.time_s:.2f} s): {self.what}"


def worst_frames(result: Result, metric: str, count: int = 3) -> list[WorstFrame]:
    """Return up to `count` frames in which a metric is worst, the worst first.

    The list is empty for a metric without a value, and for metrics without a value per frame (`dataset.*`, `perf.*`).
    """
    known = result.metrics.get(metric)
    rated = _rated(result.tables, metric) if known and known.value is not None else None
    if rated is None:
        return []
    rows = rated.rows.assign(badness=rated.badness.fillna(0.0))
    if "actor_id" in rows:
        rows = rows.assign(vehicle=rows["actor_id"].map(vehicle_names(result.tables["truth"])))
    bad = rows[rows["badness"] > 0].sort_values(["badness", "frame"], ascending=[False, True], kind="stable")
    worst = bad.drop_duplicates("frame").head(count)
    return [
        WorstFrame(row["frame"], row["time_s"], rated.describe(row), row.get("actor_id", NO_ACTOR))
        for row in worst.to_dict("records")
    ]


def vehicle_names(truth: pd.DataFrame) -> dict[int, str]:
    """Return the names of the actors by id, from the truth table: the only names of vehicles that users see."""
    first = truth.drop_duplicates("actor_id")
    return {int(actor): str(name) for actor, name in zip(first["actor_id"], first["name"], strict=True)}


def _rated(tables: Mapping[str, pd.DataFrame], metric: str) -> RatedRows | None:
    """Return the rows that a metric is computed from with their badness, by the name of the metric."""
    if metric.startswith(PREFIX):
        return None
    selection = find_metric(metric)
    family, _, measure = selection.definition.name.partition(".")
    chosen = {**selection.parameters, **selection.filters}
    match family:
        case "fit":
            return frame_badness.fits(tables["fits"], chosen.get("view", ""), chosen.get("method", "best"), measure)
        case "mma":
            return _rated_estimates(tables, measure, chosen)
        case "segmentation":
            return (
                frame_badness.merged(tables["segments"])
                if measure == "under_rate"
                else frame_badness.split(tables["truth"])
            )
        case "outliers":
            return frame_badness.outliers(tables["outliers"], chosen["cause"])
        case "control":
            driver = "truth" if measure.startswith(DRIVERS["truth"]) else "tracks"
            return frame_badness.control(tables["control"], driver, measure.removeprefix(DRIVERS[driver]))
        case "track":
            return _rated_tracks(tables, measure)
    return None


def _rated_estimates(tables: Mapping[str, pd.DataFrame], measure: str, chosen: Mapping[str, str]) -> RatedRows:
    """Return the rows of a metric of the filters."""
    model = chosen.get("model", "mma")
    if measure in MODES:
        return frame_badness.modes(tables["tracks"], standing_only=measure == "stationary_accuracy")
    if measure.startswith(("nees", "nis")):
        column = measure.partition("_")[0]
        return frame_badness.consistency(tables["tracks"], column if model == "mma" else f"{model}_{column}")
    if measure.startswith("prediction"):
        label, changing = measure.split("_")[1], chosen["when"] == "changing"
        return frame_badness.predictions(tables["truth"], tables["tracks"], model, label, changing=changing)
    axes = "xy" if measure == "gain" else measure[0]
    return frame_badness.positions(tables["tracks"], model, chosen["target"], axes)


def _rated_tracks(tables: Mapping[str, pd.DataFrame], measure: str) -> RatedRows:
    """Return the rows of a metric of tracks."""
    if measure.startswith("heading"):
        return frame_badness.headings(tables["tracks"])
    if measure in ESTIMATES:
        return track_badness.estimates(tables["truth"], tables["tracks"], measure)
    if measure in IDENTITIES:
        return frame_badness.identities(tables["truth"])
    if measure == "loca":
        return frame_badness.overlaps(tables["tracks"])
    return frame_badness.detections(tables["truth"], tables["tracks"])
