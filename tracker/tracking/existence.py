"""Existence of hidden vehicles: probability that an unseen track is still where it is predicted.

A vehicle that is not seen is behind something, or it is no longer on its course. The existence probability of
integrated data association (Musicki and Evans 1994) is applied to the whole time without an observation, because
successive scans see the same free places.
"""

import math
from dataclasses import dataclass

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats
from luxloop.compiled import kernel
from luxloop.tracker import free_space
from luxloop.tracker.bounds import require_within
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracking.corner import corner_covariance
from luxloop.tracker.tracking.track_table import COASTING, DEAD, TrackTable

QUANTILES = (-1.2816, -0.5244, 0.0, 0.5244, 1.2816)
"""Standard normal quantiles of 10, 30, 50, 70 and 90 %: middles of five equally likely parts."""

ALONG = (-0.35, 0.0, 0.35)
"""Places along a vehicle that beams cannot pass, in lengths from its centre."""

CLUTTER_PER_M2 = 0.0005
"""Density of boxes of other objects where a hidden vehicle may reappear [1/m^2]: of the boxes without a confirmed
track within 40 m in six scenes, 0.00002 to 0.0005."""

FREE_MARGIN_M = 1.0
"""Minimum distance between a free place and the returns behind it [m]."""


@dataclass(frozen=True, slots=True)
class ExistenceConfig:
    """Memory of vehicles that are hidden."""

    course_s: float = 4.0
    """Mean time in which a hidden vehicle keeps its predicted course [s]. Increase it for roads without turns."""
    existence_min: float = 0.1
    """A coasting track with a smaller probability of existence is terminated. Decrease it for longer memories of hidden
    vehicles."""
    std_max_m: float = 6.0
    """A coasting track with a larger standard deviation of its position is terminated [m]: the spacing of vehicles in a
    queue, beyond which the next one is as near to the prediction. Increase it for sparse traffic."""

    def __post_init__(self) -> None:
        require_within(self, 0.0, 1.0, "existence_min")
        require_within(self, 1e-3, 1e6, "course_s", "std_max_m")


def existence(unobserved_s: float, hidden: float, config: ExistenceConfig) -> float:
    """Return the probability that a vehicle, unseen for a time [s], exists on its course.

    A share `hidden` of the places where it is predicted is not known to be free. With the probability s of keeping the
    course, the existence is s h / (s h + 1 - s).
    """
    if hidden == 0.0:
        return 0.0
    keeps = elementary.exp(-unobserved_s / config.course_s)
    return keeps * hidden / (keeps * hidden + (1.0 - keeps))


def same_vehicle(unobserved_s: float, density_per_m2: float, config: ExistenceConfig) -> float:
    """Return the probability that a box is the vehicle that was unseen for a time [s], and no other object.

    The box has the predicted density [1/m^2] at its place.
    """
    vehicle = elementary.exp(-unobserved_s / config.course_s) * density_per_m2
    return vehicle / (vehicle + CLUTTER_PER_M2)


def terminate_lost(tracks: TrackTable, scan: Scan, config: ExistenceConfig) -> None:
    """Terminate the coasting tracks that probably do not exist any more, after the updates by a scan."""
    rows = np.flatnonzero((tracks.status == COASTING) & ~tracks.updated)
    if not len(rows):
        return
    covariance = np.array([corner_covariance(tracks, t) for t in rows.tolist()])
    boxes = tracks.subset(rows).boxes(tracks.size[rows])
    places = predicted_places(boxes.center, boxes.heading, boxes.size[:, 0].copy(), covariance) - scan.ego_pose_odom[:2]
    returns = free_space.turned_returns(scan.points_ego, scan.ego_pose_odom[2])
    free = free_space.free(places.reshape(-1, 2), returns, FREE_MARGIN_M)
    share = 1.0 - free.reshape(places.shape[:-1]).any(axis=2).mean(axis=1)
    vague = covariance[:, 0, 0] + covariance[:, 1, 1] > 2.0 * config.std_max_m**2
    for t, hidden, lost in zip(rows.tolist(), share.tolist(), vague.tolist(), strict=True):
        if lost or existence(tracks.unobserved_s.item(t), hidden, config) < config.existence_min:
            tracks.status[t] = DEAD


@kernel()
def predicted_places(center: Floats, heading: Floats, length: Floats, covariance: Floats) -> Floats:
    """(T, K, A, 2) places along each of T vehicles at K equally likely positions [m].

    Vehicles have centres (T, 2), headings (T,), lengths (T,) and covariances (T, 2, 2) of their position.
    """
    places = np.empty((len(heading), len(QUANTILES) ** 2, len(ALONG), 2))
    for t in range(len(heading)):
        cos, sin = elementary.cos(heading[t]), elementary.sin(heading[t])
        xx, xy, yy = covariance[t, 0, 0], covariance[t, 0, 1], covariance[t, 1, 1]
        axis = 0.5 * elementary.atan2(2.0 * xy, xx - yy)  # of the largest variance
        mean, half = 0.5 * (xx + yy), elementary.hypot(0.5 * (xx - yy), xy)
        major, minor = math.sqrt(mean + half), math.sqrt(max(mean - half, 0.0))
        x, y = elementary.cos(axis), elementary.sin(axis)
        for k in range(places.shape[1]):
            first, second = QUANTILES[k % len(QUANTILES)] * major, QUANTILES[k // len(QUANTILES)] * minor
            for a in range(len(ALONG)):
                places[t, k, a, 0] = center[t, 0] + x * first - y * second + cos * ALONG[a] * length[t]
                places[t, k, a, 1] = center[t, 1] + y * first + x * second + sin * ALONG[a] * length[t]
    return places
