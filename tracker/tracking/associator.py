"""Data association stage: which box updates which track."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from luxloop.tracker.arrays import Bools, Floats
from luxloop.tracker.records import Status
from luxloop.tracker.tracking.association import AssociationConfig, assign, score
from luxloop.tracker.tracking.births import nearby, second_views
from luxloop.tracker.tracking.hypotheses import Hypotheses, Predictions
from luxloop.tracker.tracking.observations import Observations
from luxloop.tracker.tracking.track import Track

ROUNDS = (Status.CONFIRMED, Status.COASTING, Status.TENTATIVE)
"""Order in which tracks choose boxes: as in the paper, previously confirmed tracks come before tentative ones. Tracks
with a single observation, without a velocity, are the last."""

NO_ROUND = -1
"""Round of terminated tracks, which get no box."""


class Associator(Protocol):
    """Data association of T tracks and B boxes."""

    def associate(
        self, tracks: Sequence[Track], predictions: Predictions, hypotheses: Hypotheses, seen: Observations
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
        seen
            The boxes. T and B may be 0.

        Returns
        -------
        list of (int, int)
            Indices of track and box; a track or a box occurs at most once.
        """


class PairScore(Protocol):
    """Cost and gate of the pairs of T tracks and B boxes."""

    def __call__(
        self, tracks: Sequence[Track], predictions: Predictions, hypotheses: Hypotheses, seen: Observations
    ) -> tuple[Floats, Bools]:
        """Return the cost (T, B) of each pair, and a mask (T, B) of admissible pairs."""


class LikelihoodScore:
    """Negative log-likelihood (11) as cost, with the gate (5), and that of births for tracks without a velocity."""

    def __init__(self, config: AssociationConfig) -> None:
        self._config = config

    def __call__(
        self, tracks: Sequence[Track], predictions: Predictions, hypotheses: Hypotheses, seen: Observations
    ) -> tuple[Floats, Bools]:
        """Return the cost (T, B) of each pair, and a mask (T, B) of admissible pairs."""
        coasting = np.array([track.status is Status.COASTING for track in tracks], dtype=np.bool_)
        cost, admissible = score(predictions, hypotheses, seen, self._config, coasting)
        if coasting.any():
            admissible[coasting] &= ~_of_another(tracks, coasting, cost, admissible)
        new = np.array([track.hits == 1 for track in tracks], dtype=np.bool_)
        if new.any():
            age = np.array([track.unseen_s for track in tracks])
            sizes = np.array([track.seen_size for track in tracks])
            second = second_views(predictions, hypotheses, seen, age, sizes, self._config.birth)
            admissible = np.where(
                new[:, None], second | admissible & nearby(hypotheses, self._config.birth), admissible
            )
        return cost, admissible


class HungarianAssociator:
    """Assignment of least total cost (4), or greedy by configuration; in rounds, by the status of the tracks."""

    def __init__(self, config: AssociationConfig, score: PairScore | None = None) -> None:
        self._config = config
        self._score = score or LikelihoodScore(config)

    def associate(
        self, tracks: Sequence[Track], predictions: Predictions, hypotheses: Hypotheses, seen: Observations
    ) -> list[tuple[int, int]]:
        """Return pairs of track and box, see `Associator.associate`."""
        cost, admissible = self._score(tracks, predictions, hypotheses, seen)
        rounds = np.array([round_of(track) for track in tracks])
        free = np.ones(len(seen), dtype=np.bool_)
        pairs: list[tuple[int, int]] = []
        for turn in sorted(set(rounds.tolist()) - {NO_ROUND}):
            chosen = assign(cost, admissible & (rounds == turn)[:, None] & free, self._config.method)
            free[[b for _, b in chosen]] = False
            pairs += chosen
        return pairs


def round_of(track: Track) -> int:
    """Return the round in which a track chooses a box, `NO_ROUND` if it must not get one."""
    if track.status is Status.DEAD:
        return NO_ROUND
    return len(ROUNDS) if track.hits == 1 else ROUNDS.index(track.status)


def _of_another(tracks: Sequence[Track], coasting: Bools, cost: Floats, admissible: Bools) -> Bools:
    """(C, B) mask of boxes of another object than each of the C `coasting` (T,) tracks.

    A tentative track that started before the coasting one was seen last follows another object: both were visible
    together. A box that fits it better is not the lost vehicle.
    """
    tentative = np.array([track.status is Status.TENTATIVE for track in tracks], dtype=np.bool_)
    age, unseen = np.array([track.age_s for track in tracks]), np.array([track.unseen_s for track in tracks])
    rival = age[tentative] > unseen[coasting, None]
    own = np.where(admissible[tentative], cost[tentative], np.inf)
    return np.asarray(np.any(rival[:, :, None] & (own < cost[coasting, None]), axis=1))
