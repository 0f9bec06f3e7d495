"""Errors of position, overlap, heading, velocity and size of pairs of truth and tracks."""

from collections.abc import Iterator

import numpy as np

from luxloop.scenarios.arrays import Ints
from luxloop.scenarios.exchange.box_metric import mean, metric
from luxloop.scenarios.exchange.distance_matching import NOT_MATCHED, DistanceStep, match_frames
from luxloop.scenarios.exchange.paired_frames import FramePairs, distances
from luxloop.scenarios.grading.plane_geometry import iou, wrap
from luxloop.scenarios.result import Metric

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
