"""Data association: cost and gate (5) of each pair of track and box, and their assignment (4)."""

from dataclasses import dataclass
from typing import Literal, NamedTuple, Protocol

import numpy as np
import scipy

from luxloop import elementary
from luxloop.arrays import Bools, Floats, Ints
from luxloop.compiled import kernel
from luxloop.tracker.bounds import require_within
from luxloop.tracker.records import Status
from luxloop.tracker.tracking.births import nearby, second_views
from luxloop.tracker.tracking.hypotheses import Hypotheses, Predictions
from luxloop.tracker.tracking.observations import Observations
from luxloop.tracker.tracking.track_table import COASTING, TENTATIVE, TrackTable

GATE_PROBABILITY_MIN = 0.1
"""A model below this probability opens no gate: the widest gate of the bank would admit every box."""

HEADING_STD_RAD = 0.1
"""Heading error beyond the fit's covariance, from rounded corners that are fitted as sides [rad]."""

GROWTH_STD_M = 1.0
"""Standard deviation of the growth of a vehicle's estimated size [m]."""


@dataclass(frozen=True, slots=True)
class AssociationConfig:
    """Data association."""

    method: Literal["hungarian", "greedy"] = "hungarian"
    """`hungarian`: least total cost (4). `greedy`: the cheapest pair, then the cheapest of the remaining ones.
    Change it to compare assignments."""
    gate_chi2: float = 13.8
    """Gate (5) on the squared Mahalanobis distance of the corner; 99.9 % of a chi-square with 2 degrees.
    Increase it for motion that the models do not describe."""
    view_std_m: float = 0.2
    """Standard deviation of the end of a vehicle between views, as from bumper to hood [m]; filters omit it.
    Set 0 for the gate of the paper."""
    shape_cost_max: float = 9.0
    """Cap on the heading and size terms of the cost (3 sigma squared), so that a bad shape cannot veto a good position.
    Set 0 for a cost and a gate of the position only, as in the paper."""

    def __post_init__(self) -> None:
        require_within(self, 1e-6, 1e6, "gate_chi2")
        require_within(self, 0.0, 1e3, "view_std_m", "shape_cost_max")


def score(
    tracks: Predictions,
    hypotheses: Hypotheses,
    observations: Observations,
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
    lenient = (
        hypotheses.innovation_lenient
        if config.shape_cost_max and hypotheses.innovation_lenient is not None
        else hypotheses.innovation
    )
    coasting = np.zeros(len(tracks.heading), dtype=np.bool_) if coasting is None else coasting
    variances = config.view_std_m**2, HEADING_STD_RAD**2
    cost, admissible = score_pairs(
        (hypotheses.innovation, lenient),
        (tracks.covariance, hypotheses.covariance),
        tracks.probability,
        (tracks.heading, tracks.heading_variance, tracks.size, tracks.whole, coasting),
        (hypotheses.heading, hypotheses.size, observations.covariance),
        (*variances, GROWTH_STD_M),
        Limits(GATE_PROBABILITY_MIN, config.gate_chi2, config.shape_cost_max),
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


class Limits(NamedTuple):
    """Limits of the cost and of the gate, see `luxloop.tracker.tracking.association.AssociationConfig`."""

    likely_min: float
    """A model below this probability opens no gate."""
    gate_chi2: float
    """Gate on squared distances."""
    shape_cost_max: float
    """Limit of the cost of heading and of size; 0 for a gate of the corner only."""


@kernel()
def squared_distance(residual: Floats, xx: float, xy: float, yy: float) -> float:
    """Squared Mahalanobis distance of a residual (2,) with covariance xx, xy, yy."""
    x, y = residual
    return float((yy * x * x - 2.0 * xy * x * y + xx * y * y) / (xx * yy - xy * xy))


@kernel()
def score_models(
    innovation: Floats,
    lenient: Floats,
    of_track: Floats,
    of_box: Floats,
    view_variance: float,
    probability: Floats,
    likely_min: float,
) -> tuple[float, float]:
    """Return the log-likelihood (11) of a box, averaged over the M models of a track, and its gate distance (5).

    The distance is the least squared one of innovations (M, 2), or of lenient ones (M, 2), over the models with a
    probability
    (M,) of `likely_min` at least; covariances are (M, 2, 2) and (2, 2), the latter plus the variance of a view [m^2].
    """
    box_xx, box_yy = of_box[0, 0] + view_variance, of_box[1, 1] + view_variance
    log_likelihood, nearest = np.empty(len(probability)), np.inf
    for m in range(len(probability)):
        xx, yy = of_track[m, 0, 0] + box_xx, of_track[m, 1, 1] + box_yy  # B = H P H' + R
        xy = of_track[m, 0, 1] + of_box[0, 1]
        squared = squared_distance(innovation[m], xx, xy, yy)
        log_likelihood[m] = elementary.log(probability[m]) - 0.5 * (squared + elementary.log(xx * yy - xy * xy))
        if probability[m] >= likely_min:
            nearest = min(nearest, squared, squared_distance(lenient[m], xx, xy, yy))
    highest, total = log_likelihood.max(), 0.0
    for m in range(len(probability)):
        total += elementary.exp(log_likelihood[m] - highest)
    return highest + elementary.log(total), nearest


@kernel()
def score_pairs(
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
        Innovations and lenient ones (T, B, M, 2) [m].
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
    (innovation, lenient), (of_track, of_box) = errors, covariances
    (own_heading, heading_variance, own_size, whole, coasting), (heading, size, of_fit) = tracks, boxes
    cost, admissible = np.empty(heading.shape), np.empty(heading.shape, np.bool_)
    for t in range(heading.shape[0]):
        for b in range(heading.shape[1]):
            pair = innovation[t, b], lenient[t, b], of_track[t], of_box[t, b], noise[0]
            log_likelihood, nearest = score_models(*pair, probability[t], limits.likely_min)
            angle = heading[t, b] - own_heading[t]
            turn = angle * angle / (heading_variance[t] + of_fit[b, 2, 2] + noise[1])
            longer = max(size[t, b, 0] - own_size[t, 0], 0.0) / noise[2]
            wider = max(size[t, b, 1] - own_size[t, 1], 0.0) / noise[2]
            along, across = longer * longer, wider * wider
            differs = min(turn, limits.shape_cost_max) + min(along + across, limits.shape_cost_max)
            cost[t, b] = differs - 2.0 * log_likelihood
            admissible[t, b] = nearest < limits.gate_chi2
            if limits.shape_cost_max > 0.0:
                too_large = along * whole[t, 0] + across * whole[t, 1] >= limits.gate_chi2
                rotated = coasting[t] and turn >= limits.gate_chi2
                admissible[t, b] &= not too_large and not rotated
    return cost, admissible


ROUNDS = (Status.CONFIRMED, Status.COASTING, Status.TENTATIVE)
"""Order in which tracks choose boxes: as in the paper, previously confirmed tracks come before tentative ones. Tracks
with a single observation, without a velocity, are the last."""

NO_ROUND = -1
"""Round of terminated tracks, which get no box."""


class Associator(Protocol):
    """Data association of T tracks and B boxes."""

    def associate(
        self, tracks: TrackTable, predictions: Predictions, hypotheses: Hypotheses, observations: Observations
    ) -> list[tuple[int, int]]:
        """Assign boxes to tracks.

        Parameters
        ----------
        tracks
            The T tracks; those with `Status.DEAD` must not get a box.
        predictions
            State of the tracks at the scan's time.
        hypotheses
            Each of the B boxes as an observation of each track.
        observations
            The boxes. T and B may be 0.

        Returns
        -------
        list of (int, int)
            Indices of track and box; a track or a box occurs at most once.
        """


class PairScore(Protocol):
    """Cost and gate of the pairs of T tracks and B boxes."""

    def __call__(
        self, tracks: TrackTable, predictions: Predictions, hypotheses: Hypotheses, observations: Observations
    ) -> tuple[Floats, Bools]:
        """Return the cost (T, B) of each pair, and a mask (T, B) of admissible pairs."""


class LikelihoodScore:
    """Negative log-likelihood (11) as cost, with the gate (5), and that of births for tracks without a velocity."""

    def __init__(self, config: AssociationConfig) -> None:
        self._config = config

    def __call__(
        self, tracks: TrackTable, predictions: Predictions, hypotheses: Hypotheses, observations: Observations
    ) -> tuple[Floats, Bools]:
        """Return the cost (T, B) of each pair, and a mask (T, B) of admissible pairs."""
        coasting = tracks.status == COASTING
        cost, admissible = score(predictions, hypotheses, observations, self._config, coasting)
        if coasting.any():
            admissible[coasting] &= ~_of_another(tracks, coasting, cost, admissible)
        new = tracks.hits == 1
        if new.any():
            second = second_views(predictions, hypotheses, observations, tracks.unobserved_s, tracks.visible_size)
            admissible = np.where(new[:, None], second | admissible & nearby(hypotheses), admissible)
        return cost, admissible


class HungarianAssociator:
    """Assignment of least total cost (4), or greedy by configuration; in rounds, by the status of the tracks."""

    def __init__(self, config: AssociationConfig, score: PairScore | None = None) -> None:
        self._config = config
        self.score = score or LikelihoodScore(config)

    def associate(
        self, tracks: TrackTable, predictions: Predictions, hypotheses: Hypotheses, observations: Observations
    ) -> list[tuple[int, int]]:
        """Return pairs of track and box, see `Associator.associate`."""
        cost, admissible = self.score(tracks, predictions, hypotheses, observations)
        rounds = rounds_of(tracks)
        free = np.ones(len(observations), dtype=np.bool_)
        pairs: list[tuple[int, int]] = []
        for turn in sorted(set(rounds.tolist()) - {NO_ROUND}):
            chosen = assign(cost, admissible & (rounds == turn)[:, None] & free, self._config.method)
            free[[b for _, b in chosen]] = False
            pairs += chosen
        return pairs


def rounds_of(tracks: TrackTable) -> Ints:
    """(T,) round in which each track chooses a box, `NO_ROUND` if it must not get one."""
    rounds = np.full(len(tracks), NO_ROUND)
    for number, status in enumerate(ROUNDS):
        rounds[tracks.status == status.value] = number
    rounds[tracks.alive & (tracks.hits == 1)] = len(ROUNDS)
    return rounds


def _of_another(tracks: TrackTable, coasting: Bools, cost: Floats, admissible: Bools) -> Bools:
    """(C, B) mask of boxes of another object than each of the C `coasting` (T,) tracks.

    A tentative track that started before the coasting one was seen last follows another object: both were visible
    together. A box that fits it better is not the lost vehicle.
    """
    tentative = tracks.status == TENTATIVE
    rival = tracks.age_s[tentative] > tracks.unobserved_s[coasting, None]
    own = np.where(admissible[tentative], cost[tentative], np.inf)
    return np.asarray(np.any(rival[:, :, None] & (own < cost[coasting, None]), axis=1))
