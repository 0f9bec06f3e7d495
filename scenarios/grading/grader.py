"""The grader: frames in, verdicts out; metrics and tables at the end. `add` is cheap, `finish` does the sums."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from scenarios.arrays import Floats, Ints
from scenarios.grading import (
    dataset_statistics,
    fit_metrics,
    frame_tables,
    mma_metrics,
    mode_metrics,
    occlusion_metrics,
    outlier_metrics,
    segmentation_metrics,
    track_metrics,
)
from scenarios.grading.bootstrap import Bootstrap
from scenarios.grading.bound import Ranging
from scenarios.grading.frame_grade import FrameGrade
from scenarios.grading.frame_tables import TableBuilder
from scenarios.grading.frame_truth import Instant
from scenarios.grading.grading_config import GradingConfig
from scenarios.grading.matching import Pairer
from scenarios.grading.metric_sheet import MetricSheet
from scenarios.grading.ownership import NOBODY, Ownership
from scenarios.grading.plane_geometry import QUARTER, wrap
from scenarios.grading.snapshots import Snapshots
from scenarios.grading.track_matches import Following
from scenarios.result import Metric
from sensor_model.truth import NO_ACTOR, ScanTruth
from sim.world import WorldFrame
from tracker.records import StepTrace, Tracks
from tracker.scan import Scan

NO_TRACE = "the tracker gives no trace of its stages"

PER_FRAME = ("range_max_m", "points_min", "bent_deg", "match_iou_min", "owner_share_min", "part_share_min")
"""Limits that count in single frames: to change them, one needs the frames."""


class Grader:
    """Holds what a tracker says against the truth, frame by frame; one grader per run.

    Parameters
    ----------
    config
        What counts, and when.
    ranging
        How the rig measures; without it, headings are not held against their bound.
    """

    def __init__(self, config: GradingConfig, ranging: Ranging | None = None) -> None:
        self._config = config
        self._ranging = ranging
        self._frames = 0
        self._pairer = Pairer(config)
        self._truth = TableBuilder(frame_tables.TRUTH)
        self._tracks = TableBuilder(frame_tables.TRACKS)
        self._overlaps = TableBuilder(frame_tables.OVERLAPS)
        self._fits = TableBuilder(frame_tables.FITS)
        self._segments = TableBuilder(frame_tables.SEGMENTS)
        self._outliers = TableBuilder(frame_tables.OUTLIERS)
        self._snapshots = Snapshots()

    def add(
        self, frame: WorldFrame, scan: Scan, truth: ScanTruth, tracks: Tracks, trace: StepTrace | None
    ) -> FrameGrade:
        """Grade one frame.

        Parameters
        ----------
        frame, truth
            The truth of the world and of the scan.
        scan
            What the tracker was given.
        tracks
            What it answered.
        trace
            How it got there, or None for a tracker that does not tell; its stages are then not graded.
        """
        self._frames += 1
        now = Instant.of(frame, scan, truth, self._config)
        following = Following.of(now, tracks, self._pairer)
        self._tracks.add(frame, following.rows(now, tracks))
        self._overlaps.add(frame, following.overlap_rows(now, tracks))

        segments, largest_share = np.zeros(len(frame.actors), np.int64), np.full(len(frame.actors), np.nan)
        box_actor, box_error = np.empty(0, np.int64), np.empty(0)
        if trace is not None:
            ownership = Ownership.of(now.point_row, trace.segments, now.graded, self._config.owner_share_min)
            segments, largest_share = self._add_stages(now, ownership, trace)
            box_actor, box_error = _grade_boxes(now, ownership, trace)
        self._truth.add(frame, now.rows(following.track_of_actor(now, tracks), segments, largest_share))
        self._snapshots.add(now, following, tracks, box_actor, box_error)
        return FrameGrade(
            graded=now.graded,
            points=now.points,
            track_actor=following.actor_id(now),
            track_heading_error=following.heading_error,
            box_actor=box_actor,
            box_heading_error=box_error,
        )

    def _add_stages(self, now: Instant, ownership: Ownership, trace: StepTrace) -> tuple[Ints, Floats]:
        """Enter the rows of segmentation, outlier removal and fitting; return the actors' segment shares."""
        share_min = self._config.part_share_min
        self._segments.add(now.frame, segmentation_metrics.rows(now.actors.id, now.graded, ownership, share_min))
        self._outliers.add(now.frame, outlier_metrics.rows(now.point_row, now.truth.cause, ownership, trace))
        self._fits.add(now.frame, fit_metrics.rows(now, ownership, trace, self._ranging))
        return segmentation_metrics.actor_shares(ownership, now.points, share_min)

    def finish(self) -> tuple[dict[str, Metric], dict[str, pd.DataFrame]]:
        """Return every metric of `metrics.GRADED` by name, and the tables behind them."""
        result = {
            "truth": self._truth.build(),
            "tracks": self._tracks.build(),
            "overlaps": self._overlaps.build(),
            "fits": fit_metrics.measure(self._fits.build()),
            "segments": self._segments.build(),
            "outliers": self._outliers.build(),
            **self._snapshots.tables(),
        }
        return grade(result, self._config, self._frames), result


def grade(table: Mapping[str, pd.DataFrame], config: GradingConfig, frames: int) -> dict[str, Metric]:
    """Return every metric of `metrics.GRADED` by name, from the tables of so many frames.

    Of the limits those of single frames (`PER_FRAME`) are in the tables already.
    """
    truth, tracks = table["truth"], table["tracks"]
    traced = len(table["outliers"]) > 0  # every frame with a trace has a row per cause
    observations = truth[truth["graded"]]
    no_vehicle = track_metrics.NO_TRUTH if traced else NO_TRACE
    no_segment = "no segment belonged mostly to a graded vehicle" if traced else NO_TRACE
    sheet = MetricSheet(Bootstrap(observations["actor_id"].to_numpy()))
    dataset_statistics.grade(sheet, observations, frames)
    fit_metrics.grade(sheet, table["fits"], len(observations) if traced else 0, no_segment)
    segmentation_metrics.grade(sheet, truth, table["segments"], config.part_share_min, no_vehicle)
    outlier_metrics.grade(sheet, table["outliers"], NO_TRACE)
    mma_metrics.grade(sheet, tracks, config.nees_confidence)
    mode_metrics.grade(sheet, tracks)
    track_metrics.grade(sheet, truth, tracks, table["overlaps"], config)
    occlusion_metrics.grade(sheet, truth, tracks, config)
    return sheet.metrics


def _grade_boxes(now: Instant, ownership: Ownership, trace: StepTrace) -> tuple[Ints, Floats]:
    """(B,) graded vehicle of each box, and the box's heading error modulo a quarter turn."""
    boxes = trace.boxes
    row = ownership.owner[boxes.segment]
    owned = np.flatnonzero(row != NOBODY)
    error = np.full(len(boxes), np.nan)
    error[owned] = wrap(boxes.heading[owned] - now.boxes_ego[row[owned], 2], QUARTER)
    return np.append(now.actors.id, NO_ACTOR)[row], error
