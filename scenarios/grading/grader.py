"""Grader of a run: `add` grades one frame and collects its table rows, `finish` computes tables and metrics."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading import fit_errors, frame_tables
from luxloop.scenarios.grading.body_points import Ranging
from luxloop.scenarios.grading.emergence import EmergenceLog, emergence_table
from luxloop.scenarios.grading.figures import Figures
from luxloop.scenarios.grading.frame_tables import TableBuilder
from luxloop.scenarios.grading.frame_truth import IS_ON_NOTHING, NO_ACTOR_ROW, FrameGrade, FrameTruth, Ownership
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.matching import TrackMatcher
from luxloop.scenarios.grading.observations import RunObservations
from luxloop.scenarios.grading.occlusions import BlockerLog, occlusion_table
from luxloop.scenarios.grading.plane_geometry import QUARTER, wrap
from luxloop.scenarios.grading.snapshots import Snapshots
from luxloop.scenarios.grading.track_matches import TrackMatches
from luxloop.scenarios.grading.truth_events.event_log import EventLog, FrameEvents
from luxloop.sensor_model.truth import NO_ACTOR, Cause, ScanTruth
from luxloop.sim.world import Collision, WorldFrame
from luxloop.tracker.records import StepTrace, Tracks
from luxloop.tracker.scan import Scan

PER_FRAME = (
    *("range_max_m", "points_min", "bent_deg", "match_iou_min", "owner_share_min", "part_share_min"),
    *("located_position_m", "located_heading_deg"),
    *("vulnerable_range_max_m", "vulnerable_points_min"),
)
"""Limits that apply in single frames. A change of these needs the frames; the tables of a run are not enough."""


class Grader:
    """Compares the output of a tracker with the ground truth, frame by frame; one grader per run.

    Parameters
    ----------
    config
        Limits of grading.
    ranging
        Beam origins and range noise of the rig; without it, there are no bounds of headings and no errors of extents.
    delivered_m
        Distance up to which simulated traffic is delivered [m]. Without it, as for labels of recorded scans, there are
        no truth events, and no actor is masked because of them.
    """

    def __init__(self, config: GradingConfig, ranging: Ranging | None = None, delivered_m: float | None = None) -> None:
        self._config = config
        self._ranging = ranging
        self._frames = 0
        self._matcher = TrackMatcher(config)
        self._truth = TableBuilder(frame_tables.TRUTH)
        self._ego = TableBuilder(frame_tables.EGO)
        self._tracks = TableBuilder(frame_tables.TRACKS)
        self._overlaps = TableBuilder(frame_tables.OVERLAPS)
        self._fits = TableBuilder(frame_tables.FITS)
        self._segments = TableBuilder(frame_tables.SEGMENTS)
        self._outliers = TableBuilder(frame_tables.OUTLIERS)
        self._snapshots = Snapshots()
        self._emergence = EmergenceLog(config)
        self._blocker_log = BlockerLog(config.hidden_fraction_max)
        self._blockers = TableBuilder(frame_tables.BLOCKERS)
        self._extremes = TableBuilder(frame_tables.EXTREMES)
        self._events: EventLog | None = None
        if delivered_m is not None:
            self._events = EventLog(config.hidden_fraction_max, config.range_max_m, delivered_m)

    def add(
        self, frame: WorldFrame, scan: Scan, truth: ScanTruth, tracks: Tracks, trace: StepTrace | None
    ) -> FrameGrade:
        """Grade one frame.

        Parameters
        ----------
        frame, truth
            Ground truth of the world and of the scan.
        scan
            Input of the tracker.
        tracks
            Output of the tracker.
        trace
            Intermediate results of the tracker's stages. Without them (None) the stages are not graded.
        """
        self._frames += 1
        events = self._events.add(frame, truth) if self._events else None
        frame_truth = FrameTruth.of(frame, scan, truth, self._config, events)
        matches = TrackMatches.of(frame_truth, tracks, self._matcher)
        if self._frames == 1:
            self._tracks = TableBuilder(frame_tables.track_schema(tracks.models))
        self._tracks.add(frame, matches.rows(frame_truth, tracks))
        self._ego.add(frame, _ego_row(frame))
        if events is not None:
            self._extremes.add(frame, _extremes_row(frame_truth, events))
        self._emergence.add(frame_truth, matches, tracks)
        self._blockers.add(frame, self._blocker_log.rows(frame_truth))
        self._overlaps.add(frame, matches.overlap_rows(frame_truth, tracks))

        segments, largest_share = np.zeros(len(frame.actors), np.int64), np.full(len(frame.actors), np.nan)
        box_actor, box_error = np.empty(0, np.int64), np.empty(0)
        if trace is not None:
            ownership = Ownership.of(
                frame_truth.point_row, trace.segments, frame_truth.boxed, self._config.owner_share_min
            )
            segments, largest_share = self._add_stages(frame_truth, ownership, trace)
            box_actor, box_error = _grade_boxes(frame_truth, ownership, trace)
        self._truth.add(frame, frame_truth.rows(matches.track_of_actor(frame_truth, tracks), segments, largest_share))
        self._snapshots.add(frame_truth, matches, tracks, box_actor, box_error)
        return FrameGrade(
            graded=frame_truth.graded,
            points=frame_truth.points,
            track_actor=matches.actor_id(frame_truth),
            track_heading_error=matches.heading_error,
            box_actor=box_actor,
            box_heading_error=box_error,
            events=events.began if events is not None else [],
        )

    def _add_stages(self, frame_truth: FrameTruth, ownership: Ownership, trace: StepTrace) -> tuple[Ints, Floats]:
        """Add the rows of segmentation, outlier removal and fitting; return `ownership.actor_shares`."""
        share_min = self._config.part_share_min
        self._segments.add(
            frame_truth.frame,
            segment_rows(frame_truth.actors.id, frame_truth.boxed, ownership, share_min),
        )
        self._outliers.add(
            frame_truth.frame, outlier_rows(frame_truth.point_row, frame_truth.truth.cause, ownership, trace)
        )
        self._fits.add(frame_truth.frame, fit_errors.fit_rows(frame_truth, ownership, trace, self._ranging))
        segments, largest_share = actor_shares(ownership, frame_truth.points, share_min)
        return segments, np.where(frame_truth.bent, np.nan, largest_share)

    def end(self, collisions: tuple[Collision, ...]) -> None:
        """Add the collisions of the ego by which the traffic ended after the last frame."""
        if self._events is not None:
            self._events.end(collisions)

    def finish(self) -> tuple[Figures, dict[str, pd.DataFrame]]:
        """Return the figures of the run, which are computed when they are asked for, and its tables."""
        truth, ego, tracks, blockers = (
            table.build() for table in (self._truth, self._ego, self._tracks, self._blockers)
        )
        result = {
            "truth": truth,
            "ego": ego,
            "emergence": emergence_table(self._emergence.first, truth, ego),
            "occlusions": occlusion_table(truth, tracks, self._config, blockers),
            "blockers": blockers,
            "tracks": tracks,
            "overlaps": self._overlaps.build(),
            "fits": fit_errors.measure(self._fits.build()),
            "segments": self._segments.build(),
            "outliers": self._outliers.build(),
            **self._snapshots.tables(),
        }
        if self._events is not None:
            result |= {"events": self._events.table(), "extremes": self._extremes.build()}
        return grade(result, self._config, self._frames), result


def grade(table: Mapping[str, pd.DataFrame], config: GradingConfig, frames: int) -> Figures:
    """Return the figures of a run, from its tables as returned by `Grader.finish` and the number of graded frames.

    The limits `PER_FRAME` have no effect: the tables already contain theirs.
    """
    return Figures(RunObservations(table, config, frames))


def _ego_row(frame: WorldFrame) -> dict[str, Floats]:
    """Return the row of the table `ego`."""
    ego = frame.ego
    values = np.concatenate([ego.pose_world, ego.size[:2], ego.velocity_world])
    return dict(zip(frame_tables.EGO, values[:, None], strict=True))


def _extremes_row(frame_truth: FrameTruth, events: FrameEvents) -> dict[str, npt.NDArray[Any]]:
    """Return the row of the table `extremes`."""
    values = {name: np.array([value]) for name, value in events.extremes.items()}
    return values | {"masked": np.array([np.count_nonzero(frame_truth.masked)])}


def _grade_boxes(frame_truth: FrameTruth, ownership: Ownership, trace: StepTrace) -> tuple[Ints, Floats]:
    """Return the id of the graded vehicle of each box (B,), and its heading error (B,) modulo a quarter turn [rad]."""
    boxes = trace.boxes
    row = ownership.owner[boxes.segment]
    owned = np.flatnonzero(row != NO_ACTOR_ROW)
    error = np.full(len(boxes), np.nan)
    error[owned] = wrap(boxes.heading[owned] - frame_truth.boxes_ego[row[owned], 2], QUARTER)
    return np.append(frame_truth.actors.id, NO_ACTOR)[row], error


def segment_rows(actor_id: Ints, graded: Bools, ownership: Ownership, share_min: float) -> dict[str, npt.NDArray[Any]]:
    """Return the segments of one frame in which a graded vehicle has a share of at least `share_min`.

    Parameters
    ----------
    actor_id, graded
        (A,) ids of the actors, and True for the graded ones.
    """
    share = ownership.counts / np.maximum(ownership.size, 1)
    touched = (share[:-1][graded] >= share_min).any(axis=0)
    segment = np.flatnonzero(touched)
    share = share[:, segment]
    ranked = np.sort(share, axis=0)
    return {
        "segment": segment,
        "points": ownership.size[segment],
        "actor_id": np.append(actor_id, NO_ACTOR)[share.argmax(axis=0)],
        "share": ranked[-1],
        "second_share": ranked[-2] if len(actor_id) else ranked[-1],
    }


def actor_shares(ownership: Ownership, points: Ints, share_min: float) -> tuple[Ints, Floats]:
    """Return the number (A,) of segments with at least `share_min` of an actor's points, and the largest share (A,).

    Parameters
    ----------
    points
        (A,) number of points on each actor.
    """
    share = ownership.counts[:-1] / np.maximum(points, 1)[:, None]
    return (share >= share_min).sum(axis=1), share.max(axis=1, initial=0.0)


def outlier_rows(
    row: Ints, cause: npt.NDArray[np.uint8], ownership: Ownership, trace: StepTrace
) -> dict[str, npt.NDArray[Any]]:
    """Count the points of one frame, and the removed ones, by cause.

    Counted are points in segments of graded vehicles that lie on the vehicle or on no object (ghosts, rain). Points of
    a neighbour are errors of segmentation and do not count.

    Parameters
    ----------
    row, cause
        (N,) actor row and cause of each point.
    """
    label = trace.segments.label
    used = np.flatnonzero(label >= 0)
    owner = ownership.owner[label[used]]
    fair = (owner != NO_ACTOR_ROW) & ((row[used] == owner) | IS_ON_NOTHING[cause[used]])
    point = used[fair]
    points = _count(label[point], cause[point], trace.segments.count)
    lost = point[trace.linkage.line[point] < 0]
    removed = _count(label[lost], cause[lost], trace.segments.count)
    return {
        "cause": np.arange(len(Cause)),
        "points": points.sum(axis=0),
        "removed": removed.sum(axis=0),
        "clean_removed_beside": removed[:, Cause.CLEAN] @ (points > 0),
    }


def _count(segment: Ints, cause: npt.NDArray[np.uint8], segments: int) -> Ints:
    """(segments, causes) table of points."""
    cell = segment * len(Cause) + cause
    return np.bincount(cell, minlength=segments * len(Cause)).reshape(segments, len(Cause))
