"""Which scan points belong to which actor, and which segments to which vehicle."""

from dataclasses import dataclass

import numpy as np

from scenarios.arrays import Bools, Ints
from sensor_model.truth import NO_ACTOR
from tracker.records import Segments

NOBODY = -1
"""Row of points that lie on no actor, and of segments that no graded vehicle owns."""


def point_rows(point_actor: Ints, actor_id: Ints) -> Ints:
    """Row (N,) in the frame's actors (A,), sorted by id, of each point's actor (N,); `NOBODY` where there is none."""
    row = np.full(len(point_actor), NOBODY, dtype=np.int64)
    on_actor = np.flatnonzero(point_actor != NO_ACTOR)
    row[on_actor] = np.searchsorted(actor_id, point_actor[on_actor])
    return row


@dataclass(frozen=True, slots=True, eq=False)
class Ownership:
    """Scan points of one frame by actor (A) and segment (S)."""

    counts: Ints
    """(A + 1, S) points of each actor in each segment; the last row is everything that is no actor."""
    size: Ints
    """(S,) points in each segment."""
    owner: Ints
    """(S,) row of the graded vehicle that owns most points of the segment, `NOBODY` where none does."""

    @classmethod
    def of(cls, row: Ints, segments: Segments, graded: Bools, share_min: float) -> "Ownership":
        """Count points (N,) given by their actor's row; an owner is graded and holds more than `share_min`."""
        shape = (len(graded) + 1, segments.count)
        used = np.flatnonzero(segments.label >= 0)
        # Row -1, nobody, is the last row of the table.
        cell = (row[used] % shape[0]) * segments.count + segments.label[used]
        counts = np.bincount(cell, minlength=shape[0] * shape[1]).reshape(shape)
        size = counts.sum(axis=0)
        holder = counts.argmax(axis=0)
        most = counts[holder, np.arange(segments.count)] > share_min * size
        owned = most & np.append(graded, False)[holder]
        return cls(counts, size, np.where(owned, holder, NOBODY))
