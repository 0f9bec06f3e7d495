"""Tracks of small road users as arrays: constant velocity filters, size memory and confirmation by motion."""

from dataclasses import dataclass, fields, replace
from functools import lru_cache

import numpy as np

from tracker.arrays import Bools, Floats, Ints
from tracker.records import SmallBoxes, Status
from tracker.tracking.small.small_config import SmallConfig

PERSON_M = np.array([0.5, 0.5])
"""(2,) length and width of a person [m]: shoulders of 0.48 m."""
RIDER_M = np.array([1.7, 0.6])
"""(2,) length and width of a bicycle with its rider [m], nuScenes' mean labels (Caesar et al. 2020)."""
RIDER_EXTENT_M = 1.0
"""Visible extent from which a small road user is a bicycle [m]: people are narrower."""


@dataclass(frozen=True, slots=True, eq=False)
class SmallTracks:
    """K tracks in the odometry frame."""

    id: Ints
    """(K,)."""
    mean: Floats
    """(K, 4) x, y, vx, vy of the centre of the visible points [m, m/s]."""
    covariance: Floats
    """(K, 4, 4)."""
    birthplace: Floats
    """(K, 2) first observation [m]."""
    way_m: Floats
    """(K,) length of the way of the estimates since then [m]."""
    hits: Ints
    """(K,) observations."""
    unseen_s: Floats
    """(K,) time since the last observation [s]; 0 for tracks that were updated."""
    extent: Floats
    """(K, 2) smoothed visible extents along and across the velocity [m]."""
    longer: Floats
    """(K,) smoothed longer visible extent [m]."""
    rides: Floats
    """(K,) smoothed share of the evidence for a bicycle, 0 to 1."""
    status: Ints
    """(K,) `Status`."""

    def __len__(self) -> int:
        return len(self.id)

    def subset(self, index: Ints | Bools) -> "SmallTracks":
        """Return the tracks of `index`."""
        return SmallTracks(*(getattr(self, field.name)[index] for field in fields(self)))

    @property
    def speed(self) -> Floats:
        """(K,) [m/s]."""
        return np.hypot(self.mean[:, 2], self.mean[:, 3])

    @property
    def heading(self) -> Floats:
        """(K,) direction of motion [rad]."""
        return np.arctan2(self.mean[:, 3], self.mean[:, 2])

    @property
    def size(self) -> Floats:
        """(K, 2) length and width [m]."""
        return np.where(self.rides[:, None] > 0.5, RIDER_M, PERSON_M)


def empty() -> SmallTracks:
    """Return no tracks."""
    none, places = np.zeros(0), np.zeros((0, 2))
    return start(SmallBoxes(np.zeros(0, dtype=np.int64), places, none, places, none), 0, SmallConfig())


def start(boxes: SmallBoxes, first_id: int, config: SmallConfig) -> SmallTracks:
    """Return a tentative track for each box, with ids from `first_id` on."""
    count = len(boxes)
    variance = np.square([*[config.position_std_m] * 2, *[config.initial_speed_std_mps] * 2])
    longer = boxes.size.max(axis=1, initial=0.0)
    return SmallTracks(
        id=first_id + np.arange(count),
        mean=np.hstack([boxes.center, np.zeros((count, 2))]),
        covariance=np.tile(np.diag(variance), (count, 1, 1)),
        birthplace=boxes.center.copy(),
        way_m=np.zeros(count),
        hits=np.ones(count, dtype=np.int64),
        unseen_s=np.zeros(count),
        extent=np.column_stack([longer, boxes.size.min(axis=1, initial=np.inf)]) if count else np.zeros((0, 2)),
        longer=longer,
        rides=(longer > RIDER_EXTENT_M).astype(np.float64),
        status=np.full(count, int(Status.TENTATIVE)),
    )


def join(first: SmallTracks, second: SmallTracks) -> SmallTracks:
    """Return the tracks of both."""
    return SmallTracks(
        *(np.concatenate([getattr(first, field.name), getattr(second, field.name)]) for field in fields(first))
    )


def predict(tracks: SmallTracks, dt: float, config: SmallConfig) -> SmallTracks:
    """Move on by `dt` [s]: constant velocity, with white acceleration (Bar-Shalom, Li, Kirubarajan 2001, 6.2.2)."""
    transition, noise = _motion(dt, 2.0 * config.acceleration_std_mps2**2 * config.acceleration_time_s)
    return replace(
        tracks,
        mean=tracks.mean @ transition.T,
        covariance=transition @ tracks.covariance @ transition.T + noise,
        unseen_s=tracks.unseen_s + dt,
    )


@lru_cache(maxsize=8)
def _motion(dt: float, density: float) -> tuple[Floats, Floats]:
    """Return transition and noise (4, 4) of a step of `dt` [s] with a density of white acceleration [m^2/s^3]."""
    transition, noise = np.eye(4), np.zeros((4, 4))
    for axis in (0, 1):
        transition[axis, axis + 2] = dt
        noise[axis, axis], noise[axis + 2, axis + 2] = density * (dt**3 / 3.0), density * dt
        noise[axis, axis + 2] = noise[axis + 2, axis] = density * (dt**2 / 2.0)
    return transition, noise


def distances(tracks: SmallTracks, boxes: SmallBoxes, config: SmallConfig) -> Floats:
    """(K, B) squared Mahalanobis distances of boxes from tracks."""
    residual = _residual(tracks, boxes)
    spread = tracks.covariance[:, :2, :2] + config.position_std_m**2 * np.eye(2)
    return np.asarray(np.einsum("kbi,kij,kbj->kb", residual, np.linalg.inv(spread), residual))


def update(tracks: SmallTracks, boxes: SmallBoxes, row: Ints, box: Ints, config: SmallConfig) -> SmallTracks:
    """Update the tracks `row` (P,) by the boxes `box` (P,)."""
    old, seen = tracks.subset(row), boxes.subset(box)
    residual = _residual(old, seen)[np.arange(len(row)), np.arange(len(row))]
    spread = old.covariance[:, :2, :2] + config.position_std_m**2 * np.eye(2)
    gain = old.covariance[:, :, :2] @ np.linalg.inv(spread)
    mean = old.mean + (gain @ residual[:, :, None])[:, :, 0]
    covariance = old.covariance - gain @ spread @ gain.swapaxes(1, 2)
    turn = np.abs(seen.heading - np.arctan2(mean[:, 3], mean[:, 2]))
    share = np.abs(np.column_stack([np.cos(turn), np.sin(turn)]))
    along = np.column_stack([(share * seen.size).sum(axis=1), (share[:, ::-1] * seen.size).sum(axis=1)])
    longer = seen.size.max(axis=1, initial=0.0)
    rides = (longer > RIDER_EXTENT_M) | (np.hypot(mean[:, 2], mean[:, 3]) > config.rider_speed_mps)
    new = replace(
        old,
        mean=mean,
        covariance=0.5 * (covariance + covariance.swapaxes(1, 2)),
        way_m=old.way_m + np.hypot(*(mean[:, :2] - old.mean[:, :2] + _step(old)).T),
        hits=old.hits + 1,
        unseen_s=np.zeros(len(row)),
        extent=old.extent + config.size_gain * (along - old.extent),
        longer=old.longer + config.size_gain * (longer - old.longer),
        rides=old.rides + config.size_gain * (rides - old.rides),
    )
    merged = {}
    for field in fields(tracks):
        merged[field.name] = getattr(tracks, field.name).copy()
        merged[field.name][row] = getattr(new, field.name)
    return SmallTracks(**merged)


def settle(tracks: SmallTracks, config: SmallConfig) -> SmallTracks:
    """Return the tracks with the status of this frame."""
    moved = np.hypot(*(tracks.mean[:, :2] - tracks.birthplace).T)
    left = tracks.speed > config.speed_min_mps
    left &= (moved > config.left_m) & (moved > config.straight_min * tracks.way_m)
    fits = (tracks.longer <= config.longer_max_m) & (tracks.extent[:, 1] <= config.wider_max_m)
    confirmed = (tracks.status != Status.TENTATIVE) & fits
    confirmed |= left & fits & (tracks.hits >= config.confirm_hits) & (tracks.unseen_s == 0.0)
    limit = np.where(confirmed, config.coast_s, config.tentative_coast_s)
    status = np.where(confirmed, int(Status.CONFIRMED), int(Status.TENTATIVE))
    status = np.where(confirmed & (tracks.unseen_s > config.gap_s), int(Status.COASTING), status)
    return replace(tracks, status=np.where(tracks.unseen_s > limit, int(Status.DEAD), status))


def _residual(tracks: SmallTracks, boxes: SmallBoxes) -> Floats:
    """(K, B, 2) boxes minus tracks, each box moved to the scan's time by the velocity of the track [m]."""
    late = boxes.time_offset[None, :, None] * tracks.mean[:, None, 2:]
    return np.asarray(boxes.center[None] - late - tracks.mean[:, None, :2])


def _step(tracks: SmallTracks) -> Floats:
    """(K, 2) way of the predictions since the last observation [m]."""
    return tracks.unseen_s[:, None] * tracks.mean[:, 2:]
