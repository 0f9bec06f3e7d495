"""Evidence of motion: a place that an object occupies was free before, or a place that it occupied is free now.

The speed of a filter is no such evidence. While more and more of a wall comes into view, or while it is seen between
two vehicles that pass it, its visible part moves like a vehicle; but the places that it covers were hidden before, and
those that it leaves are hidden, not free. Under an open sky nothing is behind a free place; a whole face that is clear
of its first places, which nothing hides, has moved there, too. Of a vehicle that moved before it was hidden, the speed
is evidence enough.
"""

from collections import deque
from collections.abc import Iterator

import numpy as np

from luxloop import elementary, elementwise
from luxloop.arrays import Bools, Floats, Ints
from luxloop.compiled import kernel
from luxloop.tracker.occupancy import FREE, NO_RETURN, OCCUPIED, Occupancy
from luxloop.tracker.tracking import small_tracks
from luxloop.tracker.tracking.track_observation import TrackObservations
from luxloop.tracker.tracking.track_table import FACE_FRACTIONS, TrackTable
from luxloop.tracker.vehicle_classes import FACE_MIN_M

INSET_M = 0.15
"""Distance of the places of an object behind its face [m], so that the returns of the face are at them."""

AGES_S = (0.4, 0.8, 1.6)
"""A place is compared with the scans of these times ago [s]: vehicles at 10, 5 and 2.5 m/s move by their length."""

SPEED_MIN_MPS = 1.5
"""Minimum speed of an object with evidence of motion [m/s]: pieces of a wall that come into view drift, too."""

SIZE_MIN_M = (small_tracks.LENGTH_MAX_M, small_tracks.WIDTH_MAX_M)
"""An object that was never seen longer or wider may be a bicycle or a person, whose motion proves no vehicle [m]."""

CLEAR_M = 1.5
"""Distance beyond its visible extent by which an object is clear of its first places [m]: the errors of two fits."""

MOVED_VIEWS_MIN = 4
"""Minimum number of successive views with evidence of motion: single beams pass hedges and fences."""


class MotionEvidence:
    """Memory of the last scans, by which tracks are seen to move."""

    def __init__(self) -> None:
        self._past: deque[Occupancy] = deque()

    def observe(self, tracks: TrackTable, observed: TrackObservations, now: Occupancy) -> None:
        """Count the evidence of this scan for the tracks that it updated by `observed`, and remember the scan."""
        while len(self._past) > 1 and now.time - self._past[1].time >= AGES_S[-1]:
            self._past.popleft()
        rows = np.flatnonzero(tracks.updated & tracks.alive & ~tracks.left)
        if len(rows):
            whole = np.isin(rows, observed.row[whole_faces(observed)])
            moved = self._moved(tracks, rows, whole, now) | tracks.moved_before_hidden[rows]
            moved &= may_be_moving_vehicle(tracks, rows)
            tracks.moved_views[rows] = np.where(moved, tracks.moved_views[rows] + 1, 0)
            tracks.left[rows] = tracks.moved_views[rows] >= MOVED_VIEWS_MIN
        self._past.append(now)

    def _moved(self, tracks: TrackTable, rows: Ints, whole: Bools, now: Occupancy) -> Bools:
        """(R,) mask of `rows`, of which a mask shows a `whole` face, with evidence; sets their first places."""
        visible = tracks.corner_sign[rows], tracks.heading[rows], tracks.visible_size[rows]
        places, first = face_places(tracks.estimate[rows, :2].copy(), *visible), tracks.first_places[rows]
        occupied, left = now.states(places) == OCCUPIED, now.states(first)
        moved = left == FREE
        for before in self._earlier(now.time):
            moved |= occupied & (before.states(places) == FREE)
        open_sky = whole & clear_of(places, first, visible[2]) & ((left == NO_RETURN) | (left == FREE)).all(axis=1)
        places[~occupied] = np.nan
        new = rows[np.isnan(first).all(axis=(1, 2))]
        tracks.first_places[new] = places[np.isin(rows, new)]
        return np.asarray(moved.any(axis=1) | open_sky)

    def _earlier(self, time: float) -> Iterator[Occupancy]:
        """Yield the last scan that is older than each of `AGES_S`, if any."""
        for age in AGES_S:
            older = [scan for scan in self._past if time - scan.time >= age]
            if older:
                yield older[-1]


def whole_faces(observed: TrackObservations) -> Bools:
    """(P,) mask of observations of a face from end to end."""
    return np.asarray((observed.untruncated & (observed.size > FACE_MIN_M)).any(axis=1))


def clear_of(places: Floats, first: Floats, size: Floats) -> Bools:
    """(R,) mask of objects of visible extents (R, 2) [m] that are far from their first places (R, P, 2)."""
    known = ~np.isnan(first).any(axis=2) & ~np.isnan(places).any(axis=2)
    away = np.where(known, elementwise.hypot(*np.moveaxis(places - first, 2, 0)), 0.0)
    return np.asarray((away > size.max(axis=1)[:, None] + CLEAR_M).any(axis=1))


def may_be_moving_vehicle(tracks: TrackTable, rows: Ints) -> Bools:
    """(R,) mask of `rows` that are fast and large enough for evidence of motion."""
    speed = elementwise.hypot(tracks.estimate[rows, 2], tracks.estimate[rows, 3])
    return np.asarray((speed > SPEED_MIN_MPS) & (tracks.visible_size[rows] > SIZE_MIN_M).any(axis=1))


@kernel()
def face_places(corner: Floats, sign: Ints, heading: Floats, size: Floats) -> Floats:
    """(T, P, 2) places on the visible faces of T tracks [m], along the heading first; NaN on faces that face away.

    Tracks have near corners (T, 2) of these signs (T, 2), headings (T,) and visible extents (T, 2).
    """
    places = np.full((len(heading), 2 * len(FACE_FRACTIONS), 2), np.nan)
    for t in range(len(heading)):
        forward, near = elementary.rotation(heading[t]), complex(corner[t, 0], corner[t, 1])
        for k, fraction in enumerate(FACE_FRACTIONS):
            along, across = fraction * size[t, 0], fraction * size[t, 1]
            if size[t, 0] > FACE_MIN_M:
                place = near - complex(sign[t, 0] * along, sign[t, 1] * INSET_M) * forward
                places[t, k] = place.real, place.imag
            if size[t, 1] > FACE_MIN_M:
                place = near - complex(sign[t, 0] * INSET_M, sign[t, 1] * across) * forward
                places[t, len(FACE_FRACTIONS) + k] = place.real, place.imag
    return places
