"""Matching of tracks with actors in single frames: the actor that each track follows."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
import numpy.typing as npt
import scipy

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.sensor_model.truth import NO_ACTOR

NO_TRACK = -1

CONTINUITY = 1000.0
"""Bonus of a pair of the last frame, far above any sum of overlaps. Identities are kept first, as in CLEAR (Bernardin
and Stiefelhagen 2008, section 2.1.3)."""


class TrackVerdict(IntEnum):
    """Verdict on a track in one frame."""

    GRADED = 0
    """Follows a graded vehicle."""
    UNGRADED = 1
    """Overlaps an actor that is not graded, or the place of one that just vanished in view, by `match_iou_min` or more,
    or is the second track of a bent truck: neither right nor wrong."""
    FALSE = 2
    """On no actor, or a second track on a graded vehicle."""
    OUTSIDE = 3
    """Beyond the graded range without an actor: neither right nor wrong."""
    UNREPORTED = 4
    """Tentative, coasting or dead: not a reported detection."""


@dataclass(frozen=True, slots=True, eq=False)
class FrameMatching:
    """Actors followed by the T reported tracks of one frame."""

    actor_row: Ints
    """(T,) row of the actor that each track follows, -1 for none."""
    verdict: npt.NDArray[np.int8]
    """(T,) `TrackVerdict`."""


class TrackMatcher:
    """Matches tracks with actors by overlap and keeps pairs from frame to frame.

    Parameters
    ----------
    config
        Least overlap of a match, and graded range.
    """

    def __init__(self, config: GradingConfig) -> None:
        self._config = config
        self._followed: dict[int, int] = {}
        """Actor id by track id, of the last frame's pairs."""

    @property
    def iou_min(self) -> float:
        """Least overlap of a track and the actor that it follows."""
        return self._config.match_iou_min

    def match(
        self,
        actor_id: Ints,
        overlap: Floats,
        graded: Bools,
        track_id: Ints,
        track_boxes: Floats,
        parted: Bools | None = None,
    ) -> FrameMatching:
        """Match the reported tracks of one frame with all actors.

        Parameters
        ----------
        actor_id, graded
            (A,) ids of the actors, and True for the graded ones.
        overlap
            (A, T) intersection over union.
        track_id, track_boxes
            (T,) ids of the tracks, and their boxes (T, 5) in the ego frame.
        parted
            (A,) True for actors of two boxes, on which a second track is neither right nor wrong; default none.
        """
        before = np.array([self._followed.get(track, NO_ACTOR) for track in track_id.tolist()], dtype=np.int64)
        score = overlap + CONTINUITY * (actor_id[:, None] == before)
        score[overlap < self._config.match_iou_min] = 0.0
        row, column = scipy.optimize.linear_sum_assignment(score, maximize=True)
        paired = score[row, column] > 0.0
        actor_row = np.full(len(track_id), -1, dtype=np.int64)
        actor_row[column[paired]] = row[paired]
        self._followed = dict(zip(track_id[column[paired]].tolist(), actor_id[row[paired]].tolist(), strict=True))
        single = graded if parted is None else graded & ~parted
        far = np.hypot(track_boxes[:, 0], track_boxes[:, 1]) > self._config.range_max_m
        return FrameMatching(actor_row, self._verdicts(overlap, actor_row, graded, single, far))

    def _verdicts(
        self, overlap: Floats, actor_row: Ints, graded: Bools, single: Bools, far: Bools
    ) -> npt.NDArray[np.int8]:
        """(T,) verdicts; an unmatched track is on the actor of its largest overlap, false if that is `single` (A,)."""
        if not len(graded):
            return np.where(far, TrackVerdict.OUTSIDE, TrackVerdict.FALSE).astype(np.int8)
        paired = actor_row >= 0
        on = np.where(paired, actor_row, overlap.argmax(axis=0))
        near = overlap.max(axis=0) >= self._config.match_iou_min
        excused = np.where(paired, ~graded[on], near & ~single[on])
        return np.select(
            [paired & graded[on], excused, far],
            [TrackVerdict.GRADED, TrackVerdict.UNGRADED, TrackVerdict.OUTSIDE],
            default=TrackVerdict.FALSE,
        ).astype(np.int8)
