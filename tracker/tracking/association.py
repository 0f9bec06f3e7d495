"""Data association: cost and gate (5) of each pair of track and box, and their assignment (4)."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import scipy

from luxloop.tracker.arrays import Bools, Floats
from luxloop.tracker.bounds import require_within
from luxloop.tracker.tracking.births import BirthConfig
from luxloop.tracker.tracking.hypotheses import Hypotheses, Predictions
from luxloop.tracker.tracking.kernels import association as kernel
from luxloop.tracker.tracking.observations import Observations


@dataclass(frozen=True, slots=True)
class AssociationConfig:
    """Data association."""

    method: Literal["hungarian", "greedy"] = "hungarian"
    """`hungarian`: least total cost (4). `greedy`: the cheapest pair, then the cheapest of the remaining ones."""
    gate_chi2: float = 13.8
    """Gate (5) on the squared Mahalanobis distance of the corner; 99.9 % of a chi-square with 2 degrees."""
    gate_probability_min: float = 0.1
    """A model below this probability opens no gate: the widest gate of the bank would admit every box."""
    view_std_m: float = 0.2
    """Standard deviation of the end of a vehicle between views, as from bumper to hood [m]; filters omit it."""
    heading_std_rad: float = 0.1
    """Heading error beyond the fit's covariance, from rounded corners that are fitted as sides [rad]."""
    growth_std_m: float = 1.0
    """Standard deviation of the growth of a vehicle's estimated size [m]."""
    birth: BirthConfig = field(default_factory=BirthConfig)
    """Second observation of a new track."""
    oddity_max: float = 9.0
    """Limit of the heading cost and of the size cost, three standard deviations: the position of a bad fit is valid."""

    def __post_init__(self) -> None:
        require_within(self, 1e-6, 1e6, "gate_chi2", "heading_std_rad", "growth_std_m")
        require_within(self, 0.0, 1e3, "gate_probability_min", "view_std_m", "oddity_max")


def score(
    tracks: Predictions,
    hypotheses: Hypotheses,
    seen: Observations,
    config: AssociationConfig,
    coasting: Bools | None = None,
) -> tuple[Floats, Bools]:
    """Return the cost (T, B) of each pair, and a mask (T, B) of boxes inside the gate (5) of any probable model.

    The cost is minus twice the log-likelihood (11), averaged over the models by their probabilities: an uncertain track
    does not win against a certain one, nor an unlikely model against a likely one. A box that is turned, or longer than
    the vehicle, costs more, so that the better of two boxes at one place is chosen. The gate of a vehicle that was
    seen from end to end excludes boxes that are much larger. That of a `coasting` (T,) track, which has not been seen
    for a while, also excludes boxes that are rotated: another object may be at its place.
    """
    reach = hypotheses.reach if config.oddity_max and hypotheses.reach is not None else hypotheses.misfit
    coasting = np.zeros(len(tracks.heading), dtype=np.bool_) if coasting is None else coasting
    variances = config.view_std_m**2, config.heading_std_rad**2
    cost, admissible = kernel.score(
        (hypotheses.misfit, reach),
        (tracks.covariance, hypotheses.covariance),
        tracks.probability,
        (tracks.heading, tracks.heading_variance, tracks.size, tracks.whole, coasting),
        (hypotheses.heading, hypotheses.size, seen.covariance),
        (*variances, config.growth_std_m),
        kernel.Limits(config.gate_probability_min, config.gate_chi2, config.oddity_max),
    )
    return cost, admissible


def assign(cost: Floats, admissible: Bools, method: str = "hungarian") -> list[tuple[int, int]]:
    """Return pairs (track, box) among the admissible ones: as many as possible at least total cost (4), or greedily."""
    tracks, boxes = (index.tolist() for index in np.nonzero(admissible))
    if len(set(tracks)) == len(tracks) and len(set(boxes)) == len(boxes):  # no pair excludes another one
        return list(zip(tracks, boxes, strict=True))
    if method == "greedy":
        return assign_greedily(cost, admissible)
    low = cost[admissible].min()
    # A forbidden pair costs more than all admissible ones together, so the optimum has the most admissible pairs.
    forbidden = (cost[admissible] - low).sum() + 1.0
    rows, columns = scipy.optimize.linear_sum_assignment(np.where(admissible, cost - low, forbidden))
    return [(int(t), int(b)) for t, b in zip(rows, columns, strict=True) if admissible[t, b]]


def assign_greedily(cost: Floats, admissible: Bools) -> list[tuple[int, int]]:
    """Return nearest-neighbour pairs: the cheapest pair, then the cheapest of the remaining ones."""
    tracks, boxes = np.nonzero(admissible)
    order = np.argsort(cost[tracks, boxes], kind="stable")
    pairs: dict[int, int] = {}
    for t, b in zip(tracks[order].tolist(), boxes[order].tolist(), strict=True):
        if t not in pairs and b not in pairs.values():
            pairs[t] = b
    return sorted(pairs.items())
