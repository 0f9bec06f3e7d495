"""Grading of tracks against true boxes, both from files: all metrics that need no run."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.exchange.box_metric_names import DEFINITIONS
from luxloop.scenarios.exchange.distance_matching import (
    NOT_MATCHED,
    DistanceStep,
    average,
    match_frames,
    recall_curve,
    track_scores,
)
from luxloop.scenarios.exchange.paired_frames import BoxLimits, FramePairs, distances, tracking_sequence
from luxloop.scenarios.grading import gospa
from luxloop.scenarios.grading.id_switches import HitStep, clear_hits
from luxloop.scenarios.grading.plane_geometry import iou, wrap
from luxloop.scenarios.grading.score_sums import TrackingScores
from luxloop.scenarios.grading.tracking_scores import VehicleScores
from luxloop.scenarios.grading.tracking_sequence import TrackingSequence
from luxloop.scenarios.result import Metric

NO_TRUTH = "the truth has no boxes"
NO_BOXES = "the files have no boxes"
NO_HITS = "no track hits a true box"


def grade(pairs: FramePairs, limits: BoxLimits) -> dict[str, Metric]:
    """Return all metrics by name; one that does not apply has the reason."""
    values = {
        **_scores(tracking_sequence(pairs), limits),
        **_gospa(pairs, limits.gospa_cutoff_m),
        **_averages(pairs, limits.pair_distance_m),
        **pair_errors(pairs, limits.pair_distance_m),
    }
    return {name: values[name] for name in DEFINITIONS}


def _scores(sequence: TrackingSequence, limits: BoxLimits) -> dict[str, Metric]:
    """Return HOTA, CLEAR and Identity."""
    hits = list(clear_hits(sequence, limits.hit_iou_min))
    scores = TrackingScores.of(VehicleScores.of(sequence, limits.hit_iou_min, hits))
    boxes = sequence["num_gt_dets"]
    found: dict[str, Metric] = {}
    for name in ("hota", "deta", "assa", "mota", "idf1", "id_switches", "fragments", "missed"):
        found |= metric(f"track.{name}", getattr(scores, name), boxes, NO_TRUTH)
    found |= metric("track.false", scores.false, max(boxes, sequence["num_tracker_dets"]), NO_BOXES)
    found |= metric("track.loca", scores.loca, scores.most_matches, NO_HITS)
    overlap = _hit_overlaps(sequence, hits)
    return found | metric("track.motp", float(overlap.mean()) if len(overlap) else None, len(overlap), NO_HITS)


def _hit_overlaps(sequence: TrackingSequence, hits: list[HitStep]) -> Floats:
    """(K,) overlaps of all hits of CLEAR."""
    found = [np.empty(0)]
    for step, vehicle, track in hits:
        rows = _places(sequence["gt_ids"][step], vehicle)
        columns = _places(sequence["tracker_ids"][step], track)
        found.append(sequence["similarity_scores"][step][rows, columns])
    return np.concatenate(found)


def _places(ids: Ints, wanted: Ints) -> Ints:
    """(k,) places of some of the ids (n,)."""
    order = np.argsort(ids)
    return np.asarray(order[np.searchsorted(ids[order], wanted)])


def _gospa(pairs: FramePairs, cutoff_m: float) -> dict[str, Metric]:
    """Return the mean GOSPA over frames with a box, and the means of its squared parts."""
    tables = [
        pd.DataFrame({"frame": frame, "x_world_m": table.boxes[:, 0], "y_world_m": table.boxes[:, 1]})
        for frame, table in ((pairs.truth_frame, pairs.truth), (pairs.track_frame, pairs.tracks))
    ]
    found = gospa.assign(tables[0], tables[1], cutoff_m)
    penalty = 0.5 * cutoff_m**2
    located = np.bincount(pairs.truth_frame[found.vehicle], found.squared, pairs.frames)
    matched = np.bincount(pairs.truth_frame[found.vehicle], minlength=pairs.frames)
    missed = penalty * (np.bincount(pairs.truth_frame, minlength=pairs.frames) - matched)
    false = penalty * (np.bincount(pairs.track_frame, minlength=pairs.frames) - matched)
    used = np.union1d(pairs.truth_frame, pairs.track_frame)
    parts = np.stack([located, missed, false])[:, used]
    metrics = mean("track.gospa_m", np.sqrt(parts.sum(axis=0)), NO_BOXES)
    for name, part in zip(("localisation", "missed", "false"), parts, strict=True):
        metrics |= mean(f"track.gospa_{name}_m2", part, NO_BOXES)
    return metrics


def _averages(pairs: FramePairs, distance_m: float) -> dict[str, Metric]:
    """Return AMOTA and AMOTP, as means over the classes of the truth."""
    names = ("track.amota", "track.amotp_m")
    if pairs.tracks.score is None:
        reason = f"{pairs.tracks.source.name} has no scores"
        return {name: Metric(None, DEFINITIONS[name].unit, 0, reason) for name in names}
    score = track_scores(pairs.track_id, pairs.tracks.score)
    found = []
    for part, kept in _by_class(pairs):
        steps = list(distance_steps(part))
        scores = [score[kept][rows] for _, rows in part.steps()]
        found.append(average(recall_curve(steps, scores, distance_m)))
    metrics: dict[str, Metric] = {}
    for name, values in zip(names, np.array(found).reshape(-1, 2).T, strict=True):
        metrics |= metric(name, float(values.mean()) if len(values) else None, len(pairs.truth), NO_TRUTH)
    return metrics


def _by_class(pairs: FramePairs) -> Iterator[tuple[FramePairs, Ints]]:
    """Yield the boxes of each class of the truth, or all of them if a file has no classes; and the rows of tracks."""
    truth, tracks = pairs.truth.kind, pairs.tracks.kind
    if truth is None or tracks is None:
        if len(pairs.truth):
            yield pairs, np.arange(len(pairs.tracks))
        return
    for name in np.unique(truth):
        yield pairs.select(truth == name, tracks == name), np.flatnonzero(tracks == name)


NO_PAIRS = "no track is near a true box"


def pair_errors(pairs: FramePairs, distance_m: float) -> dict[str, Metric]:
    """Return the errors of all pairs of truth and tracks that match by distance."""
    rows: list[tuple[Ints, Ints]] = []
    matches = match_frames(distance_steps(pairs), distance_m)
    for (true, tracked), match in zip(pairs.steps(), matches, strict=True):
        pair = np.flatnonzero(match.track != NOT_MATCHED)
        rows.append((true[pair], tracked[match.track[pair]]))
    true, tracked = (np.concatenate([np.empty(0, np.int64), *(row[k] for row in rows)]) for k in (0, 1))
    a, b = pairs.truth.boxes[true], pairs.tracks.boxes[tracked]
    error = b - a
    return {
        **mean("track.position_abs_mean_m", np.hypot(error[:, 0], error[:, 1]), NO_PAIRS),
        **mean("track.iou_mean", iou(a, b), NO_PAIRS),
        **mean("track.heading_abs_mean_deg", np.degrees(np.abs(wrap(error[:, 2]))), NO_PAIRS),
        **mean("track.length_abs_mean_m", np.abs(error[:, 3]), NO_PAIRS),
        **mean("track.width_abs_mean_m", np.abs(error[:, 4]), NO_PAIRS),
        **_velocity(pairs, true, tracked),
        **_height(pairs, true, tracked),
    }


def _velocity(pairs: FramePairs, true: Ints, tracked: Ints) -> dict[str, Metric]:
    name = "track.velocity_abs_mean_mps"
    for table in (pairs.truth, pairs.tracks):
        if table.velocity is None:
            return metric(name, None, 0, f"{table.source.name} has no velocities")
    assert pairs.truth.velocity is not None
    assert pairs.tracks.velocity is not None
    error = np.hypot(*(pairs.tracks.velocity[tracked] - pairs.truth.velocity[true]).T)
    return mean(name, error[np.isfinite(error)], f"{NO_PAIRS} with a known velocity")


def _height(pairs: FramePairs, true: Ints, tracked: Ints) -> dict[str, Metric]:
    name = "track.height_abs_mean_m"
    for table in (pairs.truth, pairs.tracks):
        if table.height_m is None:
            return metric(name, None, 0, f"{table.source.name} has no heights")
    assert pairs.truth.height_m is not None
    assert pairs.tracks.height_m is not None
    return mean(name, np.abs(pairs.tracks.height_m[tracked] - pairs.truth.height_m[true]), NO_PAIRS)


def distance_steps(pairs: FramePairs) -> Iterator[DistanceStep]:
    """Yield ids and distances of each frame."""
    for true, tracked in pairs.steps():
        yield DistanceStep(pairs.truth_id[true], pairs.track_id[tracked], distances(pairs, true, tracked))


def metric(name: str, value: float | None, n: int, why_none: str) -> dict[str, Metric]:
    """Return a metric; without a value or observations it has the reason `why_none`."""
    unit = DEFINITIONS[name].unit
    known = value is not None and n > 0
    return {name: Metric(float(value), unit, n) if known and value is not None else Metric(None, unit, n, why_none)}


def mean(name: str, values: Floats, why_none: str) -> dict[str, Metric]:
    """Return the mean of values (n,)."""
    return metric(name, float(values.mean()) if len(values) else None, len(values), why_none)
