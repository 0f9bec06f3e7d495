"""Multi-hypothesis tracking: multi-frame assignment (MFA) of Stone Soup's hypotheses with Kalman filters.

`stonesoup.dataassociator.mfa` solves the assignment by ortools, whose protobuf excludes that of commonroad-io. Here
scipy's integer program solves it: one hypothesis per track, each measurement of the last scans in one track at most,
the smallest sum of costs. Then hypotheses that contradict the best ones at the beginning of the window are removed
(N-scan pruning; Blackman 2004, IEEE AES Magazine 19, 5).
"""

from dataclasses import dataclass
from datetime import datetime
from typing import Any, ClassVar

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp

from luxloop.arrays import Floats
from luxloop.scenarios.league.trackers.joint_probabilistic import JointProbabilistic, JointSettings
from luxloop.scenarios.league.trackers.stone_soup import Associated, Settings
from luxloop.tracker.tracker import TrackerConfig


@dataclass(frozen=True, slots=True, kw_only=True)
class HypothesisSettings(JointSettings):
    """Settings of multi-hypothesis tracking."""

    window: int = 3
    """Scans in which measurements are assigned together."""
    hypotheses_max: int = 4
    """Hypotheses kept of each track."""


class MultiHypothesis(JointProbabilistic):
    """Several histories of measurements per track; the best consistent ones are reported."""

    settings_type: ClassVar[type[Settings]] = HypothesisSettings

    def __init__(self, config: TrackerConfig, *arguments: Any, **settings: Any) -> None:
        super().__init__(config, *arguments, **settings)
        from stonesoup.hypothesiser.mfa import MFAHypothesiser

        assert isinstance(self.settings, HypothesisSettings)
        self._window, self._most = self.settings.window, self.settings.hypotheses_max
        self._hypothesiser = MFAHypothesiser(self._associator.hypothesiser)

    def first_state(self, center: Floats, now: datetime) -> Any:
        """Return the mixture of a new track at `center` (2,), with one component."""
        from stonesoup.types.mixture import GaussianMixture
        from stonesoup.types.state import TaggedWeightedGaussianState

        first = super().first_state(center, now)
        one = TaggedWeightedGaussianState(first.state_vector, first.covar, timestamp=now, weight=1.0, tag=[])
        return GaussianMixture([one])

    def mean(self, track: Any) -> Floats:
        """Return the state (4,) of the best hypothesis, which is the first component."""
        return np.asarray(track.state.components[0].mean, dtype=np.float64).reshape(-1)

    def associate(self, tracks: list[Any], detections: list[Any], now: datetime) -> Associated:
        """Append the new mixture to each track, and return the measurement of its best hypothesis."""
        from stonesoup.types.mixture import GaussianMixture

        every = [self._hypothesiser.hypothesise(track, detections, now, tuple(detections)) for track in tracks]
        boxes: list[int | None] = []
        for track, hypotheses, best in zip(tracks, every, self._chosen(every), strict=True):
            begin = best.prediction.tag[: -self._window]
            kept = [each for each in hypotheses if each is not best and each.prediction.tag[: -self._window] == begin]
            kept = [best, *sorted(kept, key=_cost)[: self._most - 1]]
            track.append(GaussianMixture([self._updater.update(each) if each else each.prediction for each in kept]))
            boxes.append(best.prediction.tag[-1] - 1 if best else None)
        return Associated(boxes, [b for b in range(len(detections)) if b not in boxes])

    def _chosen(self, every: list[Any]) -> list[Any]:
        """Return the hypothesis of each track in the best assignment of the window."""
        likeliest = [min(hypotheses, key=_cost) for hypotheses in every]
        flat = [(t, each) for t, hypotheses in enumerate(every) for each in hypotheses]
        used = [[(age, box) for age, box in enumerate(reversed(each.prediction.tag[-self._window :])) if box]
                for _, each in flat]  # fmt: skip
        claimed = [pair for (t, each), pairs in zip(flat, used, strict=True) if each is likeliest[t] for pair in pairs]
        if len(claimed) == len(set(claimed)):
            return likeliest  # they agree, so that no assignment is better
        rows = {pair: row for row, pair in enumerate(sorted({pair for pairs in used for pair in pairs}))}
        of_track, of_box = np.zeros((len(every), len(flat))), np.zeros((len(rows), len(flat)))
        for column, ((t, _), pairs) in enumerate(zip(flat, used, strict=True)):
            of_track[t, column] = 1.0
            of_box[[rows[pair] for pair in pairs], column] = 1.0
        limits = [LinearConstraint(of_track, 1.0, 1.0), LinearConstraint(of_box, 0.0, 1.0)]
        found = milp([_cost(each) for _, each in flat], integrality=1, bounds=Bounds(0, 1), constraints=limits)
        assert found.x is not None  # missed measurements for all tracks, as in the best one before, are consistent
        return [flat[column][1] for column in np.flatnonzero(found.x > 0.5)]


def _cost(hypothesis: Any) -> float:
    """Return the negative logarithm of the weight of a hypothesis."""
    return -float(hypothesis.prediction.weight.log_value)
