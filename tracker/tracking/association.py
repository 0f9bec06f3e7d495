"""Which box is which track: Hungarian assignment (4) inside the gate (5)."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.optimize import linear_sum_assignment

from tracker.arrays import Bools, Floats
from tracker.bounds import require_within
from tracker.geometry import mahalanobis
from tracker.tracking.hypotheses import Hypotheses, Predictions
from tracker.tracking.observations import Observations


@dataclass(frozen=True, slots=True)
class AssociationConfig:
    """Data association."""

    method: Literal["hungarian", "greedy"] = "hungarian"
    """`hungarian`: least total cost (4). `greedy`: the cheapest pair, then the cheapest of what is left."""
    gate_chi2: float = 13.8
    """Gate (5) on the squared Mahalanobis distance of the corner; 99.9 % of a chi-square with 2 degrees."""
    gate_probability_min: float = 0.1
    """A model less likely than this opens no gate: the widest of the bank would take in everything."""
    view_std_m: float = 0.2
    """How far another view may move the end of a vehicle, from its bumper to its hood, say [m]; filters do not know."""
    heading_std_rad: float = 0.1
    """How far a fit's heading may be off beside its covariance, by taking a rounded corner for a side [rad]."""
    growth_std_m: float = 1.0
    """How much longer than thought a vehicle may turn out [m]."""
    oddity_max: float = 9.0
    """Heading and size cost no more than this each, as three standard deviations: a bad fit is still where it is."""

    def __post_init__(self) -> None:
        require_within(self, 1e-6, 1e6, "gate_chi2", "heading_std_rad", "growth_std_m")
        require_within(self, 0.0, 1e3, "gate_probability_min", "view_std_m", "oddity_max")


def score(
    tracks: Predictions, pairing: Hypotheses, seen: Observations, config: AssociationConfig
) -> tuple[Floats, Bools]:
    """(T, B) cost of each pair, and (T, B) whether the box is inside the gate of any model that may be true.

    The cost is minus twice the logarithm of the likelihood (11), weighed over the models by their probabilities:
    a vague track does not win against a sure one, nor an unlikely model against a likely one. A box that is turned, or
    longer than the vehicle, costs more, so that of two boxes at one place the right one is taken; the gate is (5).
    """
    view = config.view_std_m**2 * np.eye(2)
    spread = tracks.covariance[:, None] + pairing.covariance[:, :, None] + view  # B = H P H' + R
    squared, determinant = mahalanobis(pairing.misfit, spread)
    log_likelihood = np.log(tracks.probability)[:, None] - 0.5 * (squared + np.log(determinant))
    likely = tracks.probability[:, None] >= config.gate_probability_min
    inside: Bools = np.any(likely & (squared < config.gate_chi2), axis=2)
    odd = oddity(tracks, pairing, seen.covariance[:, 2, 2], config)
    return np.asarray(odd - 2 * np.logaddexp.reduce(log_likelihood, axis=2)), inside


def oddity(tracks: Predictions, pairing: Hypotheses, heading_variance: Floats, config: AssociationConfig) -> Floats:
    """(T, B) squared distances of heading, and of what is seen beyond the vehicle's size, each up to a limit.

    The boxes' headings have variances (B,). That less is seen than there is says nothing.
    """
    turn = pairing.heading - tracks.heading[:, None]
    variance = tracks.heading_variance[:, None] + heading_variance + config.heading_std_rad**2
    excess = np.maximum(pairing.size - tracks.size[:, None], 0.0) / config.growth_std_m
    limit = config.oddity_max
    return np.asarray(np.minimum(turn**2 / variance, limit) + np.minimum(np.sum(excess**2, axis=2), limit))


def assign(cost: Floats, admissible: Bools, method: str = "hungarian") -> list[tuple[int, int]]:
    """Pairs (track, box) among the admissible ones: as many as possible of least total cost (4), or greedily."""
    if not admissible.any():
        return []
    if method == "greedy":
        return assign_greedily(cost, admissible)
    low = cost[admissible].min()
    # A forbidden pair costs more than all admissible ones together: the optimum never trades one away for it.
    forbidden = (cost[admissible] - low).sum() + 1.0
    rows, columns = linear_sum_assignment(np.where(admissible, cost - low, forbidden))
    return [(int(t), int(b)) for t, b in zip(rows, columns, strict=True) if admissible[t, b]]


def assign_greedily(cost: Floats, admissible: Bools) -> list[tuple[int, int]]:
    """Nearest neighbours: the cheapest pair, then the cheapest of what is left."""
    tracks, boxes = np.nonzero(admissible)
    order = np.argsort(cost[tracks, boxes], kind="stable")
    pairs: dict[int, int] = {}
    for t, b in zip(tracks[order].tolist(), boxes[order].tolist(), strict=True):
        if t not in pairs and b not in pairs.values():
            pairs[t] = b
    return sorted(pairs.items())
