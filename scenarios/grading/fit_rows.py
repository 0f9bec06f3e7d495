"""Fit observations of one frame: the rectangles of every method, the selected box, and the truth."""

from typing import Any

import numpy as np
import numpy.typing as npt

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.grading import body_points, bound
from luxloop.scenarios.grading.body_points import Ranging
from luxloop.scenarios.grading.fit_errors import BOX, TRUE_BOX
from luxloop.scenarios.grading.frame_truth import FrameTruth
from luxloop.scenarios.grading.ownership import NO_ACTOR_ROW, Ownership
from luxloop.tracker.records import METHODS, Boxes, StepTrace


def rows(
    frame_truth: FrameTruth, ownership: Ownership, trace: StepTrace, ranging: Ranging | None
) -> dict[str, npt.NDArray[Any]]:
    """Return the fit observations of one frame: a row per candidate of each graded vehicle with a segment."""
    owner, segment = _largest_segments(ownership)
    fitted = trace.candidates
    methods = fitted.heading.shape[1]  # fitting the baselines, the last of `CANDIDATES`, is optional
    box = np.dstack([fitted.center_ego[segment], fitted.heading[segment], fitted.size[segment]]).reshape(-1, len(BOX))
    method = np.tile(np.arange(methods), len(segment))

    def each(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        return np.repeat(values, methods, axis=0)

    observations = {
        "segment": segment,
        "actor_id": frame_truth.actors.id[owner],
        "view": frame_truth.truth.view[owner],
        "range_m": frame_truth.range_m[owner],
        "points": ownership.size[segment],
        **_of_points(frame_truth, ranging, trace.segments.label, owner, segment),
        **_of_boxes(trace.boxes, segment),
        **dict(zip(TRUE_BOX, frame_truth.boxes_ego[owner].T, strict=True)),
    }
    columns = {
        **{name: each(values) for name, values in observations.items()},
        "method": method,
        "cost": fitted.cost[segment].ravel(),
        "best": method == each(fitted.best[segment]),
        **dict(zip(BOX, box.T, strict=True)),
    }
    kept = (method < len(METHODS)) | np.isfinite(box[:, 2])  # disabled baselines have no rows
    return {name: values[kept] for name, values in columns.items()}


def _largest_segments(ownership: Ownership) -> tuple[Ints, Ints]:
    """Return the owners (K,) and the segment (K,) with most points of each.

    As in the paper, a vehicle is observed once per frame. Its other segments are fragments, like a wheel seen under
    another car or the end of a bumper. They carry no heading information and count as over-segmentation.
    """
    segment = np.flatnonzero(ownership.owner != NO_ACTOR_ROW)
    owner = ownership.owner[segment]
    largest_first = np.argsort(-ownership.counts[owner, segment], kind="stable")
    owners, first = np.unique(owner[largest_first], return_index=True)
    return owners, segment[largest_first[first]]


def _of_points(
    frame_truth: FrameTruth, ranging: Ranging | None, label: Ints, owner: Ints, segment: Ints
) -> dict[str, Floats]:
    """Return the bound and the visible extents of each observation (K,); NaN without the rig's beams."""
    if ranging is None or not len(owner):
        return dict.fromkeys(("heading_bound_deg", "seen_length_m", "seen_width_m"), np.full(len(owner), np.nan))
    points = body_points.of_observations(frame_truth, ranging, label, owner, segment)
    length, width = body_points.extents(points, len(owner)).T
    limit = np.degrees(bound.observed(frame_truth, ranging, points, owner))
    return {"heading_bound_deg": limit, "seen_length_m": length, "seen_width_m": width}


def _of_boxes(boxes: Boxes, segment: Ints) -> dict[str, Floats]:
    """Return heading and its standard deviation of the box of each segment (K,); NaN without a box of vehicle size."""
    heading, std = np.full((2, len(segment)), np.nan)
    order = np.argsort(boxes.segment, kind="stable")
    place = np.searchsorted(boxes.segment[order], segment)
    found = np.flatnonzero(np.isin(segment, boxes.segment))
    box = order[place[found]]
    heading[found] = boxes.heading[box]
    std[found] = np.degrees(np.sqrt(boxes.covariance[box, 2, 2]))
    return {"box_heading_ego_rad": heading, "box_heading_std_deg": std}
