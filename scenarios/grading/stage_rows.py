"""Rows of segmentation and outlier removal."""

from typing import Any

import numpy as np
import numpy.typing as npt

from luxloop.scenarios.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading.frame_truth import IS_ON_NOTHING
from luxloop.scenarios.grading.ownership import NO_ACTOR_ROW, Ownership
from luxloop.sensor_model.truth import NO_ACTOR, Cause
from luxloop.tracker.records import StepTrace


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
