"""Assignment of scan points to actors, and of segments to vehicles."""

from dataclasses import dataclass

import numpy as np

from luxloop.scenarios.arrays import Bools, Ints
from luxloop.sensor_model.truth import NO_ACTOR
from luxloop.tracker.records import Segments

NO_ACTOR_ROW = -1
"""Actor row of points on no actor, and of segments without an owner."""


def point_rows(point_actor: Ints, actor_id: Ints) -> Ints:
    """Return the row (N,) of each point's actor (N,) in `actor_id` (A,), which is sorted; else `NO_ACTOR_ROW`."""
    row = np.full(len(point_actor), NO_ACTOR_ROW, dtype=np.int64)
    on_actor = np.flatnonzero(point_actor != NO_ACTOR)
    row[on_actor] = np.searchsorted(actor_id, point_actor[on_actor])
    return row


def points_of_actors(point_actor: Ints, actor_id: Ints) -> Ints:
    """(A,) number of points on each actor, of the actors (N,) of all points."""
    ids, count = np.unique(point_actor, return_counts=True)
    number = dict(zip(ids.tolist(), count.tolist(), strict=True))
    return np.array([number.get(actor, 0) for actor in actor_id.tolist()], np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class Ownership:
    """Point counts of one frame by actor (A) and segment (S), and the owner of each segment."""

    counts: Ints
    """(A + 1, S) points of each actor in each segment; the last row counts points on no actor."""
    size: Ints
    """(S,) points in each segment."""
    owner: Ints
    """(S,) row of the graded vehicle with most points of the segment, or `NO_ACTOR_ROW`."""

    @classmethod
    def of(cls, row: Ints, segments: Segments, graded: Bools, share_min: float) -> "Ownership":
        """Count points and find the owners.

        Parameters
        ----------
        row
            (N,) actor row of each point.
        segments
            Labels of the same points.
        graded
            (A,) graded actors, the possible owners.
        share_min
            An owner has a larger share of the segment's points.
        """
        shape = (len(graded) + 1, segments.count)
        used = np.flatnonzero(segments.label >= 0)
        # NO_ACTOR_ROW, -1, becomes the last row of the table.
        cell = (row[used] % shape[0]) * segments.count + segments.label[used]
        counts = np.bincount(cell, minlength=shape[0] * shape[1]).reshape(shape)
        size = counts.sum(axis=0)
        holder = counts.argmax(axis=0)
        most = counts[holder, np.arange(segments.count)] > share_min * size
        owned = most & np.append(graded, False)[holder]
        return cls(counts, size, np.where(owned, holder, NO_ACTOR_ROW))
