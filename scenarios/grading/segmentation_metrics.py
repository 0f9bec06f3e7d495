"""How well points were grouped: vehicles split, merged with something else, or not found."""

from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from scenarios.arrays import Bools, Floats, Ints
from scenarios.grading.metric_sheet import MetricSheet
from scenarios.grading.ownership import Ownership
from sensor_model.truth import NO_ACTOR


def rows(actor_id: Ints, graded: Bools, ownership: Ownership, share_min: float) -> dict[str, npt.NDArray[Any]]:
    """Return the segments of one frame of which a graded vehicle holds at least `share_min`."""
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
    """Per actor (A,): the segments that hold at least `share_min` of its points, and the largest such share."""
    share = ownership.counts[:-1] / np.maximum(points, 1)[:, None]
    return (share >= share_min).sum(axis=1), share.max(axis=1, initial=0.0)


def grade(sheet: MetricSheet, truth: pd.DataFrame, segments: pd.DataFrame, share_min: float, why_none: str) -> None:
    """Enter the `segmentation` rates.

    Over: graded vehicles with at least `share_min` of their points in each of two segments or more. Under: segments
    of which two things hold at least `share_min` each, one of them graded; everything that is no actor (ground,
    walls) is one thing. Missed: graded vehicles without a segment that holds most of their points.
    """
    seen = truth[truth["graded"] & truth["largest_segment_share"].notna()]
    sheet.mean("segmentation.over_rate", seen["segments"].to_numpy() >= 2, why_none)
    sheet.mean("segmentation.under_rate", segments["second_share"].to_numpy() >= share_min, why_none)
    sheet.mean("segmentation.missed_rate", seen["largest_segment_share"].to_numpy() <= 0.5, why_none)
