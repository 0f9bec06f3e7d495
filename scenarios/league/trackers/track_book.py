"""Ids, confirmation, heading and size of tracks whose positions another package estimates."""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np

from luxloop.arrays import Floats
from luxloop.scenarios.league.trackers.vehicle_boxes import Readings
from luxloop.tracker.geometry import wrap
from luxloop.tracker.records import Status, Tracks

TENTATIVE_S = 0.2
"""A tentative track ends after this time without a measurement [s]: two missed scans."""
MOVING_MPS = 1.0
"""Above this speed a heading is resolved by the velocity [m/s]."""
SIZE_GAIN = 0.2
"""Share of a new measurement in the size of a track."""


@dataclass(slots=True)
class Page:
    """Entry of one track."""

    id: int
    heading: float
    size: Floats
    last_s: float
    hits: int = 1
    confirmed: bool = False


class TrackBook:
    """Book of tracks by any hashable key.

    Parameters
    ----------
    confirm_hits
        Measurements after which a track is confirmed.
    coast_s
        A confirmed track ends after this time without a measurement [s].
    """

    def __init__(self, confirm_hits: int, coast_s: float) -> None:
        self._confirm_hits, self._coast_s = confirm_hits, coast_s
        self._pages: dict[Hashable, Page] = {}
        self._next_id = 0

    def start(self, key: Hashable, readings: Readings, b: int, time_s: float, forward: float) -> None:
        """Enter a track that box `b` starts; its front is the end nearer to the direction `forward` [rad]."""
        heading = _nearest(float(readings.heading[b]), forward, np.pi)
        self._pages[key] = Page(self._next_id, heading, readings.size[b].copy(), time_s)
        self._next_id += 1
        self._confirm(self._pages[key])

    def see(self, key: Hashable, readings: Readings, b: int, time_s: float, velocity: Floats) -> None:
        """Enter that box `b` is the track, which has a velocity (2,) [m/s]."""
        page = self._pages[key]
        page.hits, page.last_s = page.hits + 1, time_s
        page.size = page.size + SIZE_GAIN * (readings.size[b] - page.size)
        moving = float(np.hypot(*velocity)) > MOVING_MPS
        near = float(np.arctan2(velocity[1], velocity[0])) if moving else page.heading
        page.heading = _nearest(float(readings.heading[b]), near, 0.5 * np.pi)
        self._confirm(page)

    def ends(self, key: Hashable, time_s: float) -> bool:
        """Remove a track that has been without a measurement for too long; return True if it was."""
        page = self._pages[key]
        ended = time_s - page.last_s > (self._coast_s if page.confirmed else TENTATIVE_S)
        if ended:
            del self._pages[key]
        return ended

    def report(
        self, keys: Sequence[Hashable], centers: Sequence[Floats], velocities: Sequence[Floats], time_s: float
    ) -> Tracks:
        """Return the tracks of `keys` with centres and velocities (2,) in the odometry frame [m, m/s]."""
        pages = [self._pages[key] for key in keys]
        return Tracks.from_boxes(
            np.array([page.id for page in pages], dtype=np.int64),
            np.reshape(centers, (-1, 2)),
            np.array([page.heading for page in pages]),
            np.reshape([page.size for page in pages], (-1, 2)),
            velocity=np.reshape(velocities, (-1, 2)),
            status=np.array([self._status(page, time_s) for page in pages], dtype=np.uint8),
        )

    def _confirm(self, page: Page) -> None:
        page.confirmed = page.confirmed or page.hits >= self._confirm_hits

    @staticmethod
    def _status(page: Page, time_s: float) -> Status:
        if not page.confirmed:
            return Status.TENTATIVE
        return Status.CONFIRMED if page.last_s == time_s else Status.COASTING


def _nearest(heading: float, to: float, step: float) -> float:
    """Return the heading plus the multiple of `step` that is nearest to the direction `to`."""
    return wrap(heading + step * round((to - heading) / step))
