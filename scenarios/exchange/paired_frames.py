"""Boxes of the two files of a grading: of the same axes and classes, inside the limits, and frame by frame."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.errors import TracksError
from luxloop.scenarios.exchange.box_table import ANY_AXES, EGO_AXES, BoxTable
from luxloop.scenarios.grading.clear_table import ROUNDING
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.plane_geometry import iou_table


def in_common_axes(truth: list[BoxTable], tracks: list[BoxTable]) -> tuple[BoxTable, BoxTable]:
    """Return the first tables of both files in the same frame of reference: with velocities, and about the ego, if any.

    Raises
    ------
    TracksError
        There is none.
    """
    pairs = [(a, b) for a in truth for b in tracks if ANY_AXES in (a.axes, b.axes) or a.axes == b.axes]
    if not pairs:
        there, here = (" and ".join(table.axes for table in tables) for tables in (truth, tracks))
        raise TracksError(
            f"{tracks[0].source}: its positions are in {here} axes, those of {truth[0].source} in {there} axes; "
            "give both files in the same frame of reference"
        )

    def lacks(pair: tuple[BoxTable, BoxTable]) -> tuple[bool, bool, bool]:
        one, other = pair
        return one.axes != other.axes, one.velocity is None or other.velocity is None, one.axes not in EGO_AXES

    return min(pairs, key=lacks)


def about_the_ego(tables: list[BoxTable]) -> list[BoxTable]:
    """Return the tables whose axes start at the ego.

    Raises
    ------
    TracksError
        There is none, so the distances from the ego are unknown.
    """
    found = [table for table in tables if table.axes in EGO_AXES]
    if not found:
        axes = " and ".join(table.axes or "unnamed" for table in tables)
        raise TracksError(
            f"{tables[0].source}: its positions are in {axes} axes, so distances from the ego are unknown; "
            "give positions in the ego frame (x_ego_m), or --points-min instead of --range-max"
        )
    return found


def of_classes(truth: BoxTable, tracks: BoxTable, classes: list[str]) -> tuple[BoxTable, BoxTable]:
    """Return the boxes of some classes; tracks without classes are all kept.

    Raises
    ------
    TracksError
        The truth has no classes, or not these.
    """
    wanted = [name.strip().lower() for name in classes]
    if truth.kind is None:
        raise TracksError(f"{truth.source}: has no classes; leave --classes out")
    known = sorted(set(truth.kind.tolist()))
    missing = [name for name in wanted if name not in known]
    if missing:
        raise TracksError(f"{truth.source}: --classes {missing[0]}: not in the file; it has {', '.join(known)[:300]}")
    kept = [table if table.kind is None else table.select(_is_among(table, wanted)) for table in (truth, tracks)]
    return kept[0], kept[1]


def _is_among(table: BoxTable, names: list[str]) -> Bools:
    found: Bools = np.isin(table.kind, names)  # type: ignore[arg-type]
    return found


TIME_TOLERANCE_S = 1e-3
"""[s] Times of one frame in the two files differ by less: programs round times."""


class FramePairs(NamedTuple):
    """Truth and tracks with common numbers of frames, sorted by frame."""

    truth: BoxTable
    tracks: BoxTable
    truth_frame: Ints
    """(N,) number of the frame of each true box, from 0."""
    track_frame: Ints
    """(M,) the same of the tracks."""
    truth_id: Ints
    """(N,) renumbered id of each true box, from 0."""
    track_id: Ints
    """(M,) the same of the tracks."""
    frames: int
    """Number of frames."""

    def steps(self) -> Iterator[tuple[Ints, Ints]]:
        """Yield the rows of the truth and the rows of the tracks of each frame."""
        bounds = np.arange(self.frames + 1)
        of_truth, of_tracks = (np.searchsorted(f, bounds) for f in (self.truth_frame, self.track_frame))
        for k in range(self.frames):
            yield np.arange(of_truth[k], of_truth[k + 1]), np.arange(of_tracks[k], of_tracks[k + 1])

    @property
    def about_ego(self) -> bool:
        """True if the positions are about the ego, so that distances from it are known."""
        return bool({self.truth.axes, self.tracks.axes} & set(EGO_AXES))


@dataclass(frozen=True, slots=True)
class FrameMatching:
    """Conditions for a frame of each file to be the same instant."""

    tolerance_s: float = TIME_TOLERANCE_S
    """Times of one frame differ by at most this [s]."""
    offset_s: float = 0.0
    """Added to the times of the tracks [s]."""
    offset: int = 0
    """Added to the numbers of the frames of the tracks."""
    common: bool = False
    """Grade only frames in which both files have boxes, where one has every n-th frame."""


def pair_frames(truth: BoxTable, tracks: BoxTable, matching: FrameMatching | None = None) -> FramePairs:
    """Number the frames of two files by the first of sample, frame and time that both have.

    Raises
    ------
    TracksError
        There is none, or a sample of the tracks is unknown to the truth.
    """
    matching = matching or FrameMatching()
    frames = _frames(truth, tracks, matching)
    if matching.common:
        both = np.intersect1d(*frames)
        kept = [np.isin(frame, both) for frame in frames]
        truth, tracks = truth.select(kept[0]), tracks.select(kept[1])
        frames = (np.searchsorted(both, frames[0][kept[0]]), np.searchsorted(both, frames[1][kept[1]]))
    order = [np.argsort(frame, kind="stable") for frame in frames]
    tables = [table.select(rows) for table, rows in zip((truth, tracks), order, strict=True)]
    truth_frame, track_frame = (frame[rows] for frame, rows in zip(frames, order, strict=True))
    scenes = [_scene_ids(table, truth) for table in tables]
    ids = [np.unique(names, return_inverse=True)[1].reshape(-1).astype(np.int64) for names in scenes]
    count = int(max([-1, *truth_frame[-1:], *track_frame[-1:]])) + 1
    return FramePairs(tables[0], tables[1], truth_frame, track_frame, ids[0], ids[1], count)


UNPAIRED_MAX = 0.05
"""Fraction of the frames of a file without a box of the other, above which a warning says so."""


def unpaired(pairs: FramePairs, matching: FrameMatching) -> str:
    """Return a line on frames with boxes of one file only, if they are many; empty otherwise."""
    frames = [np.unique(frame) for frame in (pairs.truth_frame, pairs.track_frame)]
    alone = [len(np.setdiff1d(one, other)) for one, other in (frames, frames[::-1])]
    if _from_one(pairs, matching.offset):
        return "the tracks end one frame after the truth; if their numbers start from 1, give --frame-offset -1"
    if (
        matching.common
        or not all(map(len, frames))
        or all(few <= UNPAIRED_MAX * len(each) for few, each in zip(alone, frames, strict=True))
    ):
        return ""
    return (
        f"{alone[0]} of {len(frames[0])} frames with true boxes have no tracks, {alone[1]} of {len(frames[1])} with "
        "tracks no true boxes; for other clocks and rates: --time-offset, --time-tolerance, --frame-offset, "
        "--common-frames"
    )


def _from_one(pairs: FramePairs, offset: int) -> bool:
    """Return True if the numbers of the frames of the tracks are those of the truth plus 1, as far as ends show it."""
    truth, tracks = pairs.truth.frame, pairs.tracks.frame
    if truth is None or tracks is None or not len(truth) or not len(tracks) or pairs.truth.sample is not None:
        return False
    return bool(truth.min() == 0 and tracks.min() + offset >= 1 and tracks.max() + offset == truth.max() + 1)


def require_common_frames(pairs: FramePairs) -> None:
    """Raise a TracksError if both files have boxes, but in no frame both of them."""
    truth, tracks = pairs.truth, pairs.tracks
    if len(truth) and len(tracks) and not np.intersect1d(pairs.truth_frame, pairs.track_frame).size:
        raise TracksError(f"{tracks.source}: has no frame in common with {truth.source}; give tracks of the same scans")


def _frames(truth: BoxTable, tracks: BoxTable, matching: FrameMatching) -> tuple[Ints, Ints]:
    if truth.sample is not None and tracks.sample is not None:
        return _by_sample(truth, tracks)
    by_frame = truth.frame is not None and tracks.frame is not None
    if not by_frame and (truth.time_s is None or tracks.time_s is None):
        there, here = (_keys(table) for table in (truth, tracks))
        raise TracksError(f"{tracks.source}: has {here}, but {truth.source} has {there}; give both files the same")
    if (truth.scene is None) != (tracks.scene is None):
        raise TracksError(f"{tracks.source}: only one file has scenes; give both files the same")
    if truth.frame is not None and tracks.frame is not None:
        keys = (truth.frame, tracks.frame + matching.offset)
    else:
        assert truth.time_s is not None
        assert tracks.time_s is not None
        keys = _by_time(truth.time_s, tracks.time_s + matching.offset_s, matching.tolerance_s)
    return _renumbered(*(keys if truth.scene is None or tracks.scene is None else _in_scenes(truth, tracks, keys)))


def _in_scenes(truth: BoxTable, tracks: BoxTable, keys: tuple[Ints, Ints]) -> tuple[Ints, Ints]:
    """Return numbers of frames that differ from scene to scene and are in the order of the scenes."""
    assert truth.scene is not None
    assert tracks.scene is not None
    scene = np.unique(np.concatenate([truth.scene, tracks.scene]), return_inverse=True)[1].reshape(-1)
    pairs = np.column_stack([scene, np.concatenate(keys)])
    number = np.unique(pairs, axis=0, return_inverse=True)[1].reshape(-1)
    return number[: len(truth)], number[len(truth) :]


def _keys(table: BoxTable) -> str:
    return " and ".join(name for name in ("sample", "frame", "time_s") if getattr(table, name) is not None)


def _by_sample(truth: BoxTable, tracks: BoxTable) -> tuple[Ints, Ints]:
    number = {sample: index for index, sample in enumerate(truth.scene_of)}
    found = []
    for table in (truth, tracks):
        assert table.sample is not None
        unknown = [sample for sample in table.sample.tolist() if sample not in number]
        if unknown:
            raise TracksError(f"{table.source}: sample {unknown[0]} is not in {truth.source}; leave it out")
        found.append(np.array([number[sample] for sample in table.sample.tolist()], np.int64))
    return found[0], found[1]


def _renumbered(truth: npt.NDArray[np.int64], tracks: npt.NDArray[np.int64]) -> tuple[Ints, Ints]:
    values = np.unique(np.concatenate([truth, tracks]))
    return np.searchsorted(values, truth), np.searchsorted(values, tracks)


def _by_time(truth: Floats, tracks: Floats, tolerance_s: float) -> tuple[Ints, Ints]:
    """Return numbers of frames: times that are nearest to each other, and not farther than the tolerance, are one."""
    (known, true), (other, tracked) = (_frames_of(times) for times in (truth, tracks))
    if not len(known) or not len(other):
        return true, tracked
    nearest, back = _nearest(known, other), _nearest(other, known)
    same = (np.abs(known[nearest] - other) <= tolerance_s) & (back[nearest] == np.arange(len(other)))
    value = np.where(same, known[nearest], other)
    every = np.unique(np.concatenate([known, value]))
    return np.searchsorted(every, known)[true], np.searchsorted(every, value)[tracked]


def _frames_of(times: Floats) -> tuple[Floats, Ints]:
    """Return the first time of each frame of a file (F,), and the frame of each row (N,)."""
    values, row = np.unique(times, return_inverse=True)
    starts = np.concatenate([[True], np.diff(values) > TIME_TOLERANCE_S])[: len(values)]
    return values[starts], (np.cumsum(starts) - 1)[row.reshape(-1)]


def _nearest(known: Floats, wanted: Floats) -> Ints:
    """(W,) index of the known time, of which there are some in rising order, nearest to each wanted one."""
    after = np.searchsorted(known, wanted).clip(1, max(len(known) - 1, 1))
    after = np.minimum(after, len(known) - 1)
    before = np.maximum(after - 1, 0)
    found: Ints = np.where(np.abs(known[before] - wanted) <= np.abs(known[after] - wanted), before, after)
    return found


def _scene_ids(table: BoxTable, truth: BoxTable) -> npt.NDArray[np.str_]:
    """(N,) ids with the scene before them, because ids need not be unique over scenes."""
    if table.scene is not None:
        return np.array([f"{scene} {name}" for scene, name in zip(table.scene, table.id, strict=True)], np.str_)
    if table.sample is None or not truth.scene_of:
        return table.id
    scenes = [truth.scene_of.get(sample, "") for sample in table.sample.tolist()]
    return np.array([f"{scene} {name}" for scene, name in zip(scenes, table.id.tolist(), strict=True)], np.str_)


@dataclass(frozen=True, slots=True)
class BoxLimits:
    """Limits of the metrics."""

    hit_iou_min: float = 0.5
    """Least overlap of a hit of CLEAR and Identity (trackeval's default)."""
    gospa_cutoff_m: float = 2.0
    """Cut-off c of GOSPA [m], as in the grading of runs."""
    match_distance_m: float = 2.0
    """Distance of the centres below which truth and track are a pair [m], for AMOTA and errors (nuScenes)."""
    points_min: int = 0
    """Least number of LIDAR points of a true box; others, and the tracks on them, are neither right nor wrong."""
    range_max_m: float | None = None
    """Largest distance from the ego [m]; true boxes beyond, the tracks on them, and other tracks there are the same."""
    occluded_max: int | None = None
    """Highest level of occlusion of KITTI of a true box; others are the same."""
    kitti: str | None = None
    """Class of KITTI's benchmark whose boxes in the image are graded by its rules, in place of the other limits."""

    @property
    def grading(self) -> GradingConfig:
        """Limits of the metrics that runs have, too."""
        return GradingConfig(
            hit_iou_min=self.hit_iou_min, gospa_cutoff_m=self.gospa_cutoff_m, match_distance_m=self.match_distance_m
        )


def left_out(pairs: FramePairs, limits: BoxLimits) -> tuple[Bools, Bools]:
    """Return masks of the true boxes (N,) outside the limits, and of the tracks (M,) on them.

    Tracks are matched with all true boxes of a frame by the largest sum of overlaps; those matched with a box that is
    left out are left out, too, as distractors are in the benchmarks of KITTI and MOTChallenge (trackeval's
    preprocessing). So are tracks beyond the range that match no box.

    Parameters
    ----------
    pairs
        All boxes; with a limit of range, in axes about the ego.
    limits
        Limits of points, range and occlusion, and the least overlap of a match.

    Raises
    ------
    TracksError
        The truth has no numbers of points or levels of occlusion, which a limit needs.
    """
    ignored, far = outside(pairs.truth, limits), _beyond(pairs.tracks, limits.range_max_m)
    of_tracks = np.zeros(len(pairs.tracks), np.bool_)
    if not ignored.any() and not far.any():
        return ignored, of_tracks
    for true, tracked in pairs.steps():
        overlap = iou_table(pairs.truth.boxes[true], pairs.tracks.boxes[tracked])
        row, column = matched(overlap, limits.hit_iou_min)
        single = np.delete(tracked, column)
        of_tracks[tracked[column[ignored[true[row]]]]] = True
        of_tracks[single[far[single]]] = True
    return ignored, of_tracks


def outside(truth: BoxTable, limits: BoxLimits) -> Bools:
    """(N,) True for true boxes outside a limit.

    Raises
    ------
    TracksError
        As for `left_out`.
    """
    ignored = _beyond(truth, limits.range_max_m)
    if limits.points_min:
        if truth.points is None:
            raise TracksError(f"{truth.source}: has no numbers of points; leave --points-min out")
        ignored |= truth.points < limits.points_min
    if limits.occluded_max is not None:
        if truth.occluded is None:
            raise TracksError(f"{truth.source}: has no levels of occlusion, as KITTI has; leave --occluded-max out")
        ignored |= truth.occluded > limits.occluded_max
    return ignored


def _beyond(table: BoxTable, range_max_m: float | None) -> Bools:
    """(N,) True for centres beyond a distance from the origin; none without a limit."""
    found: Bools = np.hypot(table.boxes[:, 0], table.boxes[:, 1]) > (np.inf if range_max_m is None else range_max_m)
    return found


def matched(overlap: Floats, hit_iou_min: float) -> tuple[Ints, Ints]:
    """Return rows and columns of the matches in an overlap table (t, k)."""
    score = np.where(overlap < hit_iou_min - ROUNDING, 0.0, overlap)
    row, column = scipy.optimize.linear_sum_assignment(score, maximize=True)
    hit = score[row, column] > 0.0
    return row[hit], column[hit]
