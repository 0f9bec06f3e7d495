"""Cost and gate of each pair of track and box, see `luxloop.tracker.tracking.association`."""

import math
from typing import NamedTuple

import numpy as np

from luxloop.tracker.arrays import Bools, Floats
from luxloop.tracker.compiled import kernel


class Limits(NamedTuple):
    """Limits of the cost and of the gate, see `luxloop.tracker.tracking.association.AssociationConfig`."""

    likely_min: float
    """A model below this probability opens no gate."""
    gate_chi2: float
    """Gate on squared distances."""
    oddity_max: float
    """Limit of the cost of heading and of size; 0 for a gate of the corner only."""


@kernel()
def squared_distance(residual: Floats, xx: float, xy: float, yy: float) -> float:
    """Squared Mahalanobis distance of a residual (2,) with covariance xx, xy, yy."""
    x, y = residual
    return float((yy * x * x - 2.0 * xy * x * y + xx * y * y) / (xx * yy - xy * xy))


@kernel()
def score_models(
    misfit: Floats,
    reach: Floats,
    of_track: Floats,
    of_box: Floats,
    view_variance: float,
    probability: Floats,
    likely_min: float,
) -> tuple[float, float]:
    """Return the log-likelihood (11) of a box, averaged over the M models of a track, and its gate distance (5).

    The distance is the least squared one of misfits (M, 2), or of reaches (M, 2), over the models with a probability
    (M,) of `likely_min` at least; covariances are (M, 2, 2) and (2, 2), the latter plus the variance of a view [m^2].
    """
    box_xx, box_yy = of_box[0, 0] + view_variance, of_box[1, 1] + view_variance
    log_likelihood, nearest = np.empty(len(probability)), np.inf
    for m in range(len(probability)):
        xx, yy = of_track[m, 0, 0] + box_xx, of_track[m, 1, 1] + box_yy  # B = H P H' + R
        xy = of_track[m, 0, 1] + of_box[0, 1]
        squared = squared_distance(misfit[m], xx, xy, yy)
        log_likelihood[m] = math.log(probability[m]) - 0.5 * (squared + math.log(xx * yy - xy * xy))
        if probability[m] >= likely_min:
            nearest = min(nearest, squared, squared_distance(reach[m], xx, xy, yy))
    highest, total = log_likelihood.max(), 0.0
    for m in range(len(probability)):
        total += math.exp(log_likelihood[m] - highest)
    return highest + math.log(total), nearest


@kernel()
def score(
    errors: tuple[Floats, Floats],
    covariances: tuple[Floats, Floats],
    probability: Floats,
    tracks: tuple[Floats, Floats, Floats, Bools, Bools],
    boxes: tuple[Floats, Floats, Floats],
    noise: tuple[float, float, float],
    limits: Limits,
) -> tuple[Floats, Bools]:
    """Return the cost (T, B) of each pair, and a mask (T, B) of admissible pairs; see `tracker.tracking.association`.

    Only a box longer or wider than the vehicle differs in size: a smaller one may be truncated.

    Parameters
    ----------
    errors
        Misfits and reaches (T, B, M, 2) [m].
    covariances
        Those of tracks (T, M, 2, 2) and of boxes (T, B, 2, 2) [m^2].
    probability
        (T, M) of the models.
    tracks
        Headings (T,), their variances (T,), sizes (T, 2), and masks of sides (T, 2) that were seen from end to end and
        of tracks (T,) that have not been seen for a while.
    boxes
        Headings (T, B) and sizes (T, B, 2) of boxes as observations of tracks, and their covariances (B, 3, 3) of x, y
        and heading.
    noise
        Variances of the end of a vehicle between views [m^2] and of a heading beyond the fit's one [rad^2], and the
        standard deviation of the growth of a vehicle [m].
    """
    (misfit, reach), (of_track, of_box) = errors, covariances
    (own_heading, heading_variance, own_size, whole, coasting), (heading, size, of_fit) = tracks, boxes
    cost, admissible = np.empty(heading.shape), np.empty(heading.shape, np.bool_)
    for t in range(heading.shape[0]):
        for b in range(heading.shape[1]):
            pair = misfit[t, b], reach[t, b], of_track[t], of_box[t, b], noise[0]
            log_likelihood, nearest = score_models(*pair, probability[t], limits.likely_min)
            angle = heading[t, b] - own_heading[t]
            turn = angle * angle / (heading_variance[t] + of_fit[b, 2, 2] + noise[1])
            longer = max(size[t, b, 0] - own_size[t, 0], 0.0) / noise[2]
            wider = max(size[t, b, 1] - own_size[t, 1], 0.0) / noise[2]
            along, across = longer * longer, wider * wider
            differs = min(turn, limits.oddity_max) + min(along + across, limits.oddity_max)
            cost[t, b] = differs - 2.0 * log_likelihood
            admissible[t, b] = nearest < limits.gate_chi2
            if limits.oddity_max > 0.0:
                too_large = along * whole[t, 0] + across * whole[t, 1] >= limits.gate_chi2
                rotated = coasting[t] and turn >= limits.gate_chi2
                admissible[t, b] &= not too_large and not rotated
    return cost, admissible
