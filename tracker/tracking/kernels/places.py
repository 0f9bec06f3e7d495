"""Places where hidden vehicles may be, see `luxloop.tracker.tracking.memory`."""

import math

import numpy as np

from luxloop.tracker.arrays import Floats
from luxloop.tracker.compiled import kernel

QUANTILES = (-1.2816, -0.5244, 0.0, 0.5244, 1.2816)
"""Standard normal quantiles of 10, 30, 50, 70 and 90 %: middles of five equally likely parts."""

ALONG = (-0.35, 0.0, 0.35)
"""Places along a vehicle that beams cannot pass, in lengths from its centre."""


@kernel()
def predicted_places(center: Floats, heading: Floats, length: Floats, covariance: Floats) -> Floats:
    """(T, K, A, 2) places along each of T vehicles at K equally likely positions [m].

    Vehicles have centres (T, 2), headings (T,), lengths (T,) and covariances (T, 2, 2) of their position.
    """
    places = np.empty((len(heading), len(QUANTILES) ** 2, len(ALONG), 2))
    for t in range(len(heading)):
        cos, sin = math.cos(heading[t]), math.sin(heading[t])
        xx, xy, yy = covariance[t, 0, 0], covariance[t, 0, 1], covariance[t, 1, 1]
        axis = 0.5 * math.atan2(2.0 * xy, xx - yy)  # of the largest variance
        mean, half = 0.5 * (xx + yy), math.hypot(0.5 * (xx - yy), xy)
        major, minor = math.sqrt(mean + half), math.sqrt(max(mean - half, 0.0))
        x, y = math.cos(axis), math.sin(axis)
        for k in range(places.shape[1]):
            first, second = QUANTILES[k % len(QUANTILES)] * major, QUANTILES[k // len(QUANTILES)] * minor
            for a in range(len(ALONG)):
                places[t, k, a, 0] = center[t, 0] + x * first - y * second + cos * ALONG[a] * length[t]
                places[t, k, a, 1] = center[t, 1] + y * first + x * second + sin * ALONG[a] * length[t]
    return places
