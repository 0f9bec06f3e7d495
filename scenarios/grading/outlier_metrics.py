"""Precision and recall of outlier removal by T-linkage, for each cause of noise."""

from typing import Any

import numpy as np
import numpy.typing as npt

from luxloop.scenarios.arrays import Ints
from luxloop.scenarios.grading.frame_truth import IS_ON_NOTHING
from luxloop.scenarios.grading.ownership import NO_ACTOR_ROW, Ownership
from luxloop.sensor_model.truth import Cause
from luxloop.tracker.records import StepTrace


def rows(
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
