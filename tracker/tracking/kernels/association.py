"""Cost and gate of each pair of track and box, see `tracker.tracking.association`."""

import math

import numpy as np
from numba import njit

from tracker.arrays import Floats


@njit(cache=True)
def squared_distance(residual: Floats, xx: float, xy: float, yy: float) -> float:
    """Squared Mahalanobis distance of a residual (2,) with covariance xx, xy, yy."""
    x, y = residual
    return float((yy * x * x - 2.0 * xy * x * y + xx * y * y) / (xx * yy - xy * xy))


@njit(cache=True)
def score_models(
    misfit: Floats, reach: Floats, of_track: Floats, of_box: Floats, probability: Floats, likely_min: float
) -> tuple[float, float]:
    """Return the log-likelihood (11) of a box, averaged over the M models of a track, and its gate distance (5).

    The distance is the least squared one of misfits (M, 2), or of reaches (M, 2), over the models with a probability
    (M,) of `likely_min` at least; covariances are (M, 2, 2) and (2, 2).
    """
    log_likelihood, nearest = np.empty(len(probability)), np.inf
    for m in range(len(probability)):
        xx, yy = of_track[m, 0, 0] + of_box[0, 0], of_track[m, 1, 1] + of_box[1, 1]
        xy = of_track[m, 0, 1] + of_box[0, 1]
        squared = squared_distance(misfit[m], xx, xy, yy)
        log_likelihood[m] = math.log(probability[m]) - 0.5 * (squared + math.log(xx * yy - xy * xy))
        if probability[m] >= likely_min:
            nearest = min(nearest, squared, squared_distance(reach[m], xx, xy, yy))
    highest, total = log_likelihood.max(), 0.0
    for m in range(len(probability)):
        total += math.exp(log_likelihood[m] - highest)
    return highest + math.log(total), nearest


@njit(cache=True)
def score(
    misfit: Floats, reach: Floats, of_track: Floats, of_box: Floats, probability: Floats, likely_min: float
) -> tuple[Floats, Floats]:
    """Return log-likelihoods and gate distances (T, B) of all pairs, see `score_models`."""
    shape = misfit.shape[:2]
    log_likelihood, nearest = np.empty(shape), np.empty(shape)
    for t in range(shape[0]):
        for b in range(shape[1]):
            log_likelihood[t, b], nearest[t, b] = score_models(
                misfit[t, b], reach[t, b], of_track[t], of_box[t, b], probability[t], likely_min
            )
    return log_likelihood, nearest
