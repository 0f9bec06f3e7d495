"""Which box is which track: Hungarian assignment (4) inside the gate (5)."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from tracker.geometry import QUARTER, rotate
from tracker.observations import Observations
from tracker.records import Bools, Floats, Ints


@dataclass(frozen=True, slots=True)
class AssociationConfig:
    """Data association."""

    gate_chi2: float = 13.8
    """Gate (5) on the squared Mahalanobis distance of the corner; 99.9 % of a chi-square with 2 degrees."""
    gate_probability_min: float = 0.1
    """A model less likely than this opens no gate: the widest of the bank would take in everything."""
    corner_margin_m: float = 0.5
    """Another corner must be nearer to the ego by this much before the track moves over to it."""

    def __post_init__(self) -> None:
        if self.gate_chi2 <= 0 or self.corner_margin_m < 0:
            raise ValueError("gate_chi2 must be above 0 and corner_margin_m must not be negative")


@dataclass(frozen=True, slots=True, eq=False)
class Predictions:
    """What T tracks expect to see by each of M models, in the odometry frame."""

    position: Floats
    """(T, M, 2) tracked corner [m]."""
    covariance: Floats
    """(T, M, 2, 2) of the tracked corner."""
    probability: Floats
    """(T, M) of each model."""
    heading: Floats
    """(T,)."""
    size: Floats
    """(T, 2) length, width [m]."""
    corner_sign: Ints
    """(T, 2) which corner is tracked."""

    def __len__(self) -> int:
        return len(self.heading)


@dataclass(frozen=True, slots=True, eq=False)
class Pairing:
    """Every box read as an observation of every track, (T, B) pairs, in the odometry frame."""

    heading: Floats
    """(T, B) the box's heading, turned by quarters towards the track's."""
    size: Floats
    """(T, B, 2) seen extent along and across that heading [m]."""
    corner_sign: Ints
    """(T, B, 2) the corner of the vehicle that is measured."""
    position: Floats
    """(T, B, 2) where the box has that corner [m]."""
    side: Floats
    """(T, B, 2) from the tracked corner to the measured one, by the track's heading and size [m]."""


def pair(tracks: Predictions, seen: Observations, config: AssociationConfig) -> Pairing:
    """Read each of B boxes as each of T tracks: whole turns of the box are resolved by the track's heading.

    The measured corner is the nearest one, but the tracked one keeps its place until another is nearer by
    `corner_margin_m`; in between both are seen equally well and a change would only cost accuracy.
    """
    turns = np.round((tracks.heading[:, None] - seen.heading) / QUARTER)
    heading = seen.heading + turns * QUARTER
    size = np.where((turns % 2 == 1)[..., None], seen.size[:, ::-1], seen.size)
    nearest = np.round(rotate(np.broadcast_to(seen.corner_sign, size.shape), -turns * QUARTER))
    tracked = np.broadcast_to(tracks.corner_sign[:, None], size.shape)

    def corner(sign: Floats | Ints) -> Floats:
        return np.asarray(seen.center + rotate(0.5 * sign * size, heading))

    range_m = [np.linalg.norm(corner(sign) - seen.sensor, axis=-1) for sign in (tracked, nearest)]
    keeps = range_m[0] <= range_m[1] + config.corner_margin_m
    sign = np.where(keeps[..., None], tracked, nearest).astype(np.int64)
    side = rotate(0.5 * (sign - tracked) * tracks.size[:, None], tracks.heading[:, None])
    return Pairing(heading=heading, size=size, corner_sign=sign, position=corner(sign), side=side)


def distance(tracks: Predictions, seen: Observations, pairing: Pairing) -> tuple[Floats, Floats]:
    """(T, B, M) squared Mahalanobis distance of (5) by each model, and log-determinant of its B = H P H' + R."""
    spread = tracks.covariance[:, None] + seen.covariance[None, :, None, :2, :2]
    residual = (pairing.position - pairing.side)[:, :, None] - tracks.position[:, None]
    squared = np.einsum("tbmi,tbmij,tbmj->tbm", residual, np.linalg.inv(spread), residual)
    return np.asarray(squared), np.asarray(np.log(np.linalg.det(spread)))


def assign(cost: Floats, admissible: Bools) -> list[tuple[int, int]]:
    """Pairs (track, box) of least total cost among the admissible ones, as many as possible, equation (4)."""
    if not admissible.any():
        return []
    low = cost[admissible].min()
    # A forbidden pair costs more than all admissible ones together: the optimum never trades one away for it.
    forbidden = (cost[admissible] - low).sum() + 1.0
    rows, columns = linear_sum_assignment(np.where(admissible, cost - low, forbidden))
    return [(int(t), int(b)) for t, b in zip(rows, columns, strict=True) if admissible[t, b]]


def associate(
    tracks: Predictions, seen: Observations, pairing: Pairing, config: AssociationConfig
) -> list[tuple[int, int]]:
    """Pairs (track, box): the most likely assignment inside the gate of any model that may be true.

    The cost is minus twice the logarithm of the likelihood (11), weighed over the models by their probabilities:
    a vague track does not win against a sure one, nor an unlikely model against a likely one.
    """
    squared, log_determinant = distance(tracks, seen, pairing)
    log_likelihood = np.log(tracks.probability)[:, None] - 0.5 * (squared + log_determinant)
    likely = tracks.probability[:, None] >= config.gate_probability_min
    inside = (likely & (squared < config.gate_chi2)).any(axis=2)
    return assign(-2 * np.logaddexp.reduce(log_likelihood, axis=2), inside)
