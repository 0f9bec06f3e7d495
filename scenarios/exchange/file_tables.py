"""Truth and tracks of files as the tables of a run, so that metrics, filters and reports are the same.

Boxes in the image are graded by the rules of KITTI's benchmark.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import pandas as pd

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.errors import TracksError
from luxloop.scenarios.exchange.box_table import BoxTable
from luxloop.scenarios.exchange.paired_frames import BoxLimits, FramePairs, left_out, matched
from luxloop.scenarios.grading import fit_errors, frame_tables
from luxloop.scenarios.grading.distance_matching import NOT_MATCHED, DistanceStep, match_frames
from luxloop.scenarios.grading.frame_tables import Schema, TableBuilder
from luxloop.scenarios.grading.matching import TrackVerdict
from luxloop.scenarios.grading.plane_geometry import iou, iou_table, wrap
from luxloop.sensor_model.truth import NO_ACTOR
from luxloop.sim.modes import ModeLimits
from luxloop.tracker.records import MODELS, Status

SIMILAR: Mapping[str, str] = {"car": "van", "pedestrian": "person"}
"""Classes of the benchmark, and the similar class of each."""
REGION = "dontcare"
OCCLUDED_MAX, TRUNCATED_MAX = 2, 0
"""Highest levels of graded objects."""
LOWEST_PX = 25.0
"""[pixels] Tracks on no object that are at most as high are left out."""
INSIDE_MIN = 0.5
"""Tracks on no object are left out if a larger fraction of them is inside a region."""


def of_class(truth: BoxTable, tracks: BoxTable, name: str) -> tuple[BoxTable, BoxTable]:
    """Return the boxes that the rules of a class need: regions and both classes of the truth, one of the tracks."""
    assert truth.kind is not None
    if name not in SIMILAR:
        raise TracksError(f"--kitti {name}: no class of KITTI's benchmark; give one of {', '.join(SIMILAR)}")
    # Tracks of a file of labels have levels of occlusion and truncation, too; they do not count.
    tracks = replace(tracks, occluded=None, truncated=None)
    return truth.select(np.isin(truth.kind, [name, SIMILAR[name], REGION])), tracks.select(
        np.asarray(tracks.kind == name)
    )


def left_out_by_benchmark(pairs: FramePairs, limits: BoxLimits) -> tuple[Bools, Bools]:
    """Return masks of the true boxes (N,) and of the tracks (M,) that are neither right nor wrong by KITTI's rules."""
    truth, tracks = pairs.truth, pairs.tracks
    assert truth.occluded is not None
    assert truth.truncated is not None
    region = np.asarray(truth.kind == REGION)
    ignored = np.asarray(truth.kind != limits.kitti)
    ignored |= (truth.occluded > OCCLUDED_MAX) | (truth.truncated > TRUNCATED_MAX)
    of_tracks = np.zeros(len(tracks), np.bool_)
    for true, tracked in pairs.steps():
        objects, regions = true[~region[true]], true[region[true]]
        row, column = matched(iou_table(truth.boxes[objects], tracks.boxes[tracked]), limits.hit_iou_min)
        single = np.delete(tracked, column)
        is_inside = (_inside(tracks.boxes[single], truth.boxes[regions]) > INSIDE_MIN).any(axis=1)
        of_tracks[tracked[column[ignored[objects[row]]]]] = True
        of_tracks[single[is_inside | (tracks.boxes[single, 4] <= LOWEST_PX)]] = True
    return ignored, of_tracks


def _inside(boxes: Floats, regions: Floats) -> Floats:
    """(k, r) fraction of each box in the image that is inside each region."""
    centre, half = boxes[:, None, :2], 0.5 * boxes[:, None, 3:]
    low = np.maximum(centre - half, regions[:, :2] - 0.5 * regions[:, 3:])
    high = np.minimum(centre + half, regions[:, :2] + 0.5 * regions[:, 3:])
    shared: Floats = np.maximum(high - low, 0.0).prod(axis=2) / boxes[:, None, 3:].prod(axis=2)
    return shared


STANDING_BELOW_MPS = 0.5 * (ModeLimits().stands_below_mps + ModeLimits().moves_from_mps)
"""[m/s] Slower vehicles are standing: the limit of a vehicle in its first frame in runs."""


class Pairing(NamedTuple):
    """True boxes that the tracks are on."""

    row: Ints
    """(M,) row of the true box of each track, -1 for none."""
    paired: Bools
    """(M,) True for the pairs by distance, whose errors count."""


def tables_of(pairs: FramePairs, limits: BoxLimits) -> dict[str, pd.DataFrame]:
    """Return the tables of a run, those of the stages of a tracker without rows.

    Errors are those of pairs by distance, as in nuScenes. A track that hits a box without such a pair is on it, too.
    """
    ignored, unjudged = (left_out_by_benchmark if limits.kitti else left_out)(pairs, limits)
    pairing = _pair(pairs, ~ignored, ~unjudged, limits)
    return {
        **of_stages(),
        "truth": truth_table(pairs, ~ignored).assign(track_id=_followers(pairs, pairing)),
        "tracks": _tracks(pairs, pairing, unjudged),
        "overlaps": _overlaps(pairs),
    }


def of_stages() -> dict[str, pd.DataFrame]:
    """Return the tables of a run without a row."""
    found = {name: TableBuilder(schema).build() for name, schema in frame_tables.SCHEMAS.items()}
    return {**found, "fits": fit_errors.measure(found["fits"])}


def _pair(pairs: FramePairs, graded: Bools, judged: Bools, limits: BoxLimits) -> Pairing:
    """Return the true box of each judged track: by distance, and else by overlap."""
    steps = [(true[graded[true]], tracked[judged[tracked]]) for true, tracked in pairs.steps()]
    near = (DistanceStep(pairs.truth_id[a], pairs.track_id[b], _distances(pairs, a, b)) for a, b in steps)
    row, distance_max = np.full(len(pairs.tracks), NOT_MATCHED), 0.0 if limits.kitti else limits.match_distance_m
    for (true, tracked), match in zip(steps, match_frames(near, distance_max), strict=True):
        pair = match.track != NOT_MATCHED
        row[tracked[match.track[pair]]] = true[pair]
    paired = row != NOT_MATCHED
    for true, tracked in steps:
        true, tracked = np.setdiff1d(true, row[tracked]), tracked[~paired[tracked]]
        overlap = iou_table(pairs.truth.boxes[true], pairs.tracks.boxes[tracked])
        hit, column = matched(overlap, limits.hit_iou_min)
        row[tracked[column]] = true[hit]
    return Pairing(row, paired)


def _followers(pairs: FramePairs, pairing: Pairing) -> Ints:
    """(N,) id of the track on each true box, -1 for none."""
    found, on = np.full(len(pairs.truth), NO_ACTOR), np.flatnonzero(pairing.row >= 0)
    found[pairing.row[on]] = pairs.track_id[on]
    return found


def _distances(pairs: FramePairs, true: Ints, tracked: Ints) -> Floats:
    """(t, k) distances of the centres of true boxes (t,) and tracks (k,), given by their rows [m]."""
    apart = pairs.truth.boxes[true, None, :2] - pairs.tracks.boxes[None, tracked, :2]
    found: Floats = np.hypot(apart[..., 0], apart[..., 1])
    return found


def truth_table(pairs: FramePairs, graded: Bools) -> pd.DataFrame:
    """Return the table of true boxes; `graded` (N,) are those that count."""
    table = pairs.truth
    columns = {
        **_boxes(pairs, table, pairs.truth_frame),
        "actor_id": pairs.truth_id,
        "name": table.id,
        "kind": _classes(table),
        "mode": _modes(table),
        "yaw_rate_radps": np.zeros(len(table)),  # unknown; the centre, where velocities apply, does not feel it
        "points": np.full(len(table), NO_ACTOR) if table.points is None else table.points,
        "graded": graded,
        "track_id": np.full(len(table), NO_ACTOR),
    }
    return filled(frame_tables.TRUTH, columns)


def _tracks(pairs: FramePairs, pairing: Pairing, unjudged: Bools) -> pd.DataFrame:
    table, on, row = pairs.tracks, pairing.row >= 0, pairing.row
    verdict = np.where(on, TrackVerdict.GRADED, np.where(unjudged, TrackVerdict.UNGRADED, TrackVerdict.FALSE))
    error, overlap, height = (np.full(len(table), np.nan) for _ in range(3))
    true, box = pairs.truth.boxes[row[on]], table.boxes[on]
    error[on], overlap[on] = np.degrees(wrap(box[:, 2] - true[:, 2])), iou(true, box)
    if table.height_m is not None and pairs.truth.height_m is not None:
        height[on] = table.height_m[on] - pairs.truth.height_m[row[on]]
    columns = {
        **_boxes(pairs, table, pairs.track_frame),
        "track_id": pairs.track_id,
        "status": _category([Status.CONFIRMED] * len(table), frame_tables.TRACKS["status"]),
        "verdict": _category(verdict, frame_tables.TRACKS["verdict"]),
        "actor_id": np.append(pairs.truth_id, NO_ACTOR)[row],
        "true_mode": _category(np.append(_modes(pairs.truth).codes, -1)[row], MODELS),
        "iou": overlap,
        "heading_error_deg": error,
        "judged": pairing.paired,
        # Positions and velocities are those of the centre, not of a corner.
        "corner_along": np.zeros(len(table)),
        "corner_across": np.zeros(len(table)),
        "score": np.full(len(table), np.nan) if table.score is None else table.score,
        "height_error_m": height,
        "kind": _classes(table),
    }
    return filled(frame_tables.TRACKS, columns)


def _overlaps(pairs: FramePairs) -> pd.DataFrame:
    """Return all pairs of boxes that overlap."""
    found: list[tuple[Ints, Ints, Floats]] = [(np.empty(0, np.int64), np.empty(0, np.int64), np.empty(0))]
    for true, tracked in pairs.steps():
        overlap = iou_table(pairs.truth.boxes[true], pairs.tracks.boxes[tracked])
        row, column = np.nonzero(overlap)
        found.append((true[row], tracked[column], overlap[row, column]))
    true, tracked, overlap = (np.concatenate([part[k] for part in found]) for k in range(3))
    columns = {
        "frame": pairs.truth_frame[true], "time_s": _times(pairs.truth)[true], "actor_id": pairs.truth_id[true],
        "track_id": pairs.track_id[tracked], "iou": overlap,
    }  # fmt: skip
    return pd.DataFrame(columns)


def _boxes(pairs: FramePairs, table: BoxTable, frame: Ints) -> dict[str, npt.NDArray[Any]]:
    """Return frame, box, velocity and range; the axes are those of the files, also in columns named after the world."""
    boxes = table.boxes
    velocity = np.full((len(table), 2), np.nan) if table.velocity is None else table.velocity
    return {
        "frame": frame, "time_s": _times(table),
        "x_world_m": boxes[:, 0], "y_world_m": boxes[:, 1], "yaw_world_rad": boxes[:, 2],
        "length_m": boxes[:, 3], "width_m": boxes[:, 4],
        "vx_world_mps": velocity[:, 0], "vy_world_mps": velocity[:, 1],
        "range_m": np.hypot(boxes[:, 0], boxes[:, 1]) if pairs.about_ego else np.full(len(table), np.nan),
    }  # fmt: skip


def _times(table: BoxTable) -> Floats:
    return np.full(len(table), np.nan) if table.time_s is None else table.time_s


def _classes(table: BoxTable) -> pd.Categorical:
    """(N,) name of the class of each box, empty without one."""
    return pd.Categorical(np.full(len(table), "") if table.kind is None else table.kind)


def _modes(table: BoxTable) -> pd.Categorical:
    """(N,) standing or not, from the velocity; unknown without one. Moving modes are not distinguished in files."""
    speed = np.full(len(table), np.nan) if table.velocity is None else np.hypot(*table.velocity.T)
    return _category(np.where(np.isnan(speed), -1, speed >= STANDING_BELOW_MPS), MODELS)


def _category(codes: Any, names: Any) -> pd.Categorical:
    return pd.Categorical.from_codes(np.asarray(codes, np.int64), list(names))


UNKNOWN: Mapping[Any, Any] = {np.float64: np.nan, np.int64: NO_ACTOR, np.bool_: False, np.str_: ""}
"""Value of columns that files lack, by their type."""


def filled(schema: Schema, columns: Mapping[str, Any]) -> pd.DataFrame:
    """Return a table with these columns, and those of the schema that are not among them."""
    count = len(columns["frame"])
    missing = {
        name: pd.Categorical.from_codes(np.full(count, -1), list(kind))
        if isinstance(kind, tuple)
        else np.full(count, UNKNOWN[kind])
        for name, kind in schema.items()
        if name not in columns
    }
    return pd.DataFrame({**columns, **missing})
