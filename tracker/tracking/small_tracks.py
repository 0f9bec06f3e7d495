"""Settings of the tracks of small road users."""

from dataclasses import dataclass, fields
from functools import lru_cache
from operator import attrgetter

import numpy as np

from luxloop import elementwise
from luxloop.arrays import Bools, Floats, Ints
from luxloop.tracker.records import SmallBoxes, Status

LENGTH_MAX_M = 2.0
"""Maximum length of a bicycle with its rider [m]: nuScenes' labels are 1.7 by 0.6 m on average."""

WIDTH_MAX_M = 1.0
"""Maximum width of a rider or a person with swinging arms [m]; vehicles are wider."""

POSITION_STD_M = 0.15
"""Standard deviation of the centre of the points [m]: legs and arms swing, and one side of a person of 0.3 to 0.5 m
is visible."""

ACCELERATION_STD_MPS2 = 0.7
"""Acceleration of people who walk: 0.68 on average (Teknomo 2002) [m/s^2]; cyclists start with 0.6 to 0.9
(Parkin and Rotheram 2010)."""

ACCELERATION_TIME_S = 0.5
"""Its correlation time, a step at 2 steps a second [s]; the spectral density is 2 x 0.7^2 x 0.5 = 0.5 m^2/s^3."""

INITIAL_SPEED_STD_MPS = 2.5
"""Standard deviation of the first speed along an axis [m/s]: people walk at 1.34 (Weidmann 1993), and cyclists ride
at 4 to 6."""

GATE_CHI2 = 13.8
"""Gate on the squared Mahalanobis distance of an observation: 99.9 % of chi-square with 2 degrees of freedom."""

LEFT_M = 0.8
"""Distance from the first place at which a track is confirmed [m]: more than the width of a person, so that another
view of a pole or a trunk is no motion."""

SPEED_MIN_MPS = 0.5
"""Least speed at confirmation [m/s]; slow walkers do 0.7, two standard deviations below the mean."""

STRAIGHT_MIN = 0.7
"""Least distance from the first place, as a fraction of the way of the track's estimates: noise wanders."""

CONFIRM_HITS = 8
"""Least number of observations for confirmation: a person walks `left_m` in 0.6 s, and parts of passing vehicles
that look small are rarely visible for longer."""

TENTATIVE_COAST_S = 0.2
"""A tentative track is terminated if it was not seen for longer than this [s]."""

GAP_S = 0.25
"""A confirmed track stays confirmed through gaps up to this length [s] and coasts after it."""

COAST_S = 1.0
"""A confirmed track is terminated if it was not seen for longer than this [s]: a person's course is unknown to
0.35 m after it."""

SIZE_GAIN = 0.1
"""Gain of the filter of the visible extents."""

RIDER_SPEED_MPS = 3.0
"""A small road user faster than this rides [m/s]: joggers run at 2.5 to 3."""

VEHICLE_MARGIN_M = 0.4
"""Points within this distance of a vehicle's box are a part of it [m]: mirrors, and errors of its size."""

ATTACHED_M = 1.5
"""Points within this distance of a moving vehicle's box that keep its speed are a part of it [m]: long mirrors, and
ends of a truck that its box does not cover yet."""

ATTACHED_SPEED_MPS = 1.0
"""Largest difference of the velocities of a vehicle and its part [m/s], and least speed of that vehicle."""

WHOLE_VIEWS_MIN = 3
"""Least number of views of both sides from end to end after which a vehicle's box that was never seen larger than a
bicycle is a bicycle; a part of a vehicle behind others is truncated."""

SAME_M = 1.0
"""A track of vehicle stages and a small one are of one object within this distance of their centres [m]."""


@dataclass(frozen=True, slots=True)
class SmallConfig:
    """Tracks of people and bicycles: sizes, motion, and confirmation.

    A person has no visible shape at this resolution, and stands like a pole. Only motion distinguishes them, so a
    person is confirmed after a few steps, and one that never walks is not.
    """

    enabled: bool = True
    """Track small road users beside the vehicles. Set false to track vehicles only, as in the paper."""


PERSON_M = np.array([0.5, 0.5])
"""(2,) length and width of a person [m]: shoulders of 0.48 m."""
RIDER_M = np.array([1.7, 0.6])
"""(2,) length and width of a bicycle with its rider [m], nuScenes' mean labels (Caesar et al. 2020)."""
RIDER_EXTENT_M = 1.0
"""Visible extent from which a small road user is a bicycle [m]: people are narrower."""


@dataclass(slots=True, eq=False)
class SmallTracks:
    """K tracks in the odometry frame: one table of arrays, which the stages change in place."""

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
    unobserved_s: Floats
    """(K,) time since the last observation [s]; 0 for tracks that were updated."""
    extent: Floats
    """(K, 2) smoothed visible extents along and across the velocity [m]."""
    longer: Floats
    """(K,) smoothed longer visible extent [m]."""
    rides: Floats
    """(K,) smoothed fraction of the evidence for a bicycle, 0 to 1."""
    status: Ints
    """(K,) `Status`."""

    def __len__(self) -> int:
        return len(self.id)

    def subset(self, index: Ints | Bools) -> "SmallTracks":
        """Return the tracks of `index`."""
        return SmallTracks(*[column[index] for column in _columns(self)])

    @property
    def speed(self) -> Floats:
        """(K,) [m/s]."""
        return elementwise.hypot(self.mean[:, 2], self.mean[:, 3])

    @property
    def heading(self) -> Floats:
        """(K,) direction of motion [rad]."""
        return elementwise.atan2(self.mean[:, 3], self.mean[:, 2])

    @property
    def size(self) -> Floats:
        """(K, 2) length and width [m]."""
        return np.where(self.rides[:, None] > 0.5, RIDER_M, PERSON_M)


_columns = attrgetter(*[field.name for field in fields(SmallTracks)])
"""Arrays of a table, in the order of its fields."""


def empty() -> SmallTracks:
    """Return no tracks."""
    none, places = np.zeros(0), np.zeros((0, 2))
    return start(SmallBoxes(np.zeros(0, dtype=np.int64), places, none, places, none), 0)


def start(boxes: SmallBoxes, first_id: int) -> SmallTracks:
    """Return a tentative track for each box, with ids from `first_id` on."""
    count = len(boxes)
    variance = np.square([*[POSITION_STD_M] * 2, *[INITIAL_SPEED_STD_MPS] * 2])
    mean, extent, longer = np.zeros((count, 4)), np.empty((count, 2)), boxes.size.max(axis=1, initial=0.0)
    mean[:, :2], extent[:, 0], extent[:, 1] = boxes.center, longer, boxes.size.min(axis=1, initial=np.inf)
    return SmallTracks(
        id=first_id + np.arange(count),
        mean=mean,
        covariance=np.tile(np.diag(variance), (count, 1, 1)),
        birthplace=boxes.center.copy(),
        way_m=np.zeros(count),
        hits=np.ones(count, dtype=np.int64),
        unobserved_s=np.zeros(count),
        extent=extent,
        longer=longer,
        rides=(longer > RIDER_EXTENT_M).astype(np.float64),
        status=np.full(count, int(Status.TENTATIVE)),
    )


def join(first: SmallTracks, second: SmallTracks) -> SmallTracks:
    """Return the tracks of both."""
    return SmallTracks(*[np.concatenate(pair) for pair in zip(_columns(first), _columns(second), strict=True)])


def predict(tracks: SmallTracks, dt: float) -> None:
    """Move on by `dt` [s]: constant velocity, with white acceleration (Bar-Shalom, Li, Kirubarajan 2001, 6.2.2)."""
    transition, noise = _motion(dt, 2.0 * ACCELERATION_STD_MPS2**2 * ACCELERATION_TIME_S)
    tracks.mean = elementwise.product(tracks.mean, transition.T)
    tracks.covariance = elementwise.product(elementwise.product(transition, tracks.covariance), transition.T) + noise
    tracks.unobserved_s += dt


@lru_cache(maxsize=8)
def _motion(dt: float, density: float) -> tuple[Floats, Floats]:
    """Return transition and noise (4, 4) of a step of `dt` [s] with a density of white acceleration [m^2/s^3]."""
    transition, noise = np.eye(4), np.zeros((4, 4))
    for axis in (0, 1):
        transition[axis, axis + 2] = dt
        noise[axis, axis], noise[axis + 2, axis + 2] = density * (dt * dt * dt / 3.0), density * dt
        noise[axis, axis + 2] = noise[axis + 2, axis] = density * (dt**2 / 2.0)
    return transition, noise


def distances(tracks: SmallTracks, boxes: SmallBoxes) -> Floats:
    """(K, B) squared Mahalanobis distances of boxes from tracks."""
    residual = _residual(tracks.mean[:, None], boxes.center, boxes.time_offset)
    spread = tracks.covariance[:, :2, :2] + POSITION_STD_M**2 * np.eye(2)
    return np.asarray((elementwise.product(residual, elementwise.inverse(spread)) * residual).sum(axis=2))


def update(tracks: SmallTracks, boxes: SmallBoxes, row: Ints, box: Ints) -> None:
    """Update the tracks `row` (P,) by the boxes `box` (P,)."""
    old, covariance, size = tracks.mean[row], tracks.covariance[row], boxes.size[box]
    residual = _residual(old, boxes.center[box], boxes.time_offset[box])
    spread = covariance[:, :2, :2] + POSITION_STD_M**2 * np.eye(2)
    gain = elementwise.product(covariance[:, :, :2], elementwise.inverse(spread))
    mean = old + elementwise.product(gain, residual[:, :, None])[:, :, 0]
    covariance = covariance - elementwise.product(elementwise.product(gain, spread), gain.swapaxes(1, 2))
    since = mean[:, :2] - old[:, :2] + tracks.unobserved_s[row, None] * old[:, 2:]
    tracks.mean[row], tracks.covariance[row] = mean, 0.5 * (covariance + covariance.swapaxes(1, 2))
    tracks.way_m[row] += elementwise.hypot(since[:, 0], since[:, 1])
    tracks.hits[row] += 1
    tracks.unobserved_s[row] = 0.0
    longer, rider = size.max(axis=1, initial=0.0), elementwise.hypot(mean[:, 2], mean[:, 3]) > RIDER_SPEED_MPS
    extent = _extents(size, boxes.heading[box] - elementwise.atan2(mean[:, 3], mean[:, 2]))
    new = (tracks.extent, extent), (tracks.longer, longer), (tracks.rides, (longer > RIDER_EXTENT_M) | rider)
    for column, seen in new:
        column[row] += SIZE_GAIN * (seen - column[row])


def settle(tracks: SmallTracks) -> None:
    """Update the status of the tracks at the end of a frame."""
    way, speed = tracks.mean[:, :2] - tracks.birthplace, tracks.speed
    moved = elementwise.hypot(way[:, 0], way[:, 1])
    left = (speed > SPEED_MIN_MPS) & (moved > LEFT_M) & (moved > STRAIGHT_MIN * tracks.way_m)
    fits = (tracks.longer <= LENGTH_MAX_M) & (tracks.extent[:, 1] <= WIDTH_MAX_M)
    shown = left & (tracks.hits >= CONFIRM_HITS) & (tracks.unobserved_s == 0.0)
    confirmed = fits & ((tracks.status != Status.TENTATIVE.value) | shown)
    tracks.status[:] = np.where(confirmed, int(Status.CONFIRMED), int(Status.TENTATIVE))
    tracks.status[confirmed & (tracks.unobserved_s > GAP_S)] = int(Status.COASTING)
    tracks.status[tracks.unobserved_s > np.where(confirmed, COAST_S, TENTATIVE_COAST_S)] = int(Status.DEAD)


def _extents(size: Floats, turn: Floats) -> Floats:
    """(P, 2) extents along and across the velocity of boxes of sizes (P, 2), whose headings are `turn` (P,) from it."""
    cos, sin, (length, width) = np.abs(elementwise.cos(turn)), np.abs(elementwise.sin(turn)), size.T
    extents = np.empty_like(size)
    extents[:, 0], extents[:, 1] = cos * length + sin * width, sin * length + cos * width
    return extents


def _residual(mean: Floats, center: Floats, time_offset: Floats) -> Floats:
    """(..., 2) centres of boxes minus those of tracks with states (..., 4) [m].

    Each box is moved to the scan's time, `time_offset` before its own [s], by the velocity of the track.
    """
    return np.asarray(center - time_offset[:, None] * mean[..., 2:] - mean[..., :2])
