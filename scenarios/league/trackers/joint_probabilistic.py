"""Joint probabilistic data association (JPDA) with a Kalman filter, by Stone Soup."""

from dataclasses import dataclass
from datetime import datetime
from typing import Any, ClassVar

import numpy as np
import scipy

from luxloop.scenarios.league.trackers.stone_soup import Associated, Settings, StoneSoupTracker
from luxloop.tracker.tracker import TrackerConfig


@dataclass(frozen=True, slots=True, kw_only=True)
class JointSettings(Settings):
    """Settings of JPDA."""

    detect_probability: float = 0.9
    clutter_per_m2: float = 0.01
    """Density of measurements without a vehicle [1/m^2]."""


class JointProbabilistic(StoneSoupTracker):
    """Each track is updated by all measurements in its gate, by the probabilities of their joint assignments."""

    settings_type: ClassVar[type[Settings]] = JointSettings

    def __init__(self, config: TrackerConfig, *arguments: Any, **settings: Any) -> None:
        super().__init__(config, *arguments, **settings)
        from stonesoup.dataassociator.probability import JPDAwithEHM2
        from stonesoup.hypothesiser.probability import PDAHypothesiser
        from stonesoup.predictor.kalman import KalmanPredictor
        from stonesoup.updater.kalman import KalmanUpdater

        own = self.settings
        assert isinstance(own, JointSettings)
        self._updater = KalmanUpdater(self.measured)
        in_gate = float(scipy.stats.chi2.cdf(own.gate_sigma**2, 2))
        predictor = KalmanPredictor(self.motion)
        self._associator = JPDAwithEHM2(
            PDAHypothesiser(predictor, self._updater, own.clutter_per_m2, own.detect_probability, in_gate)
        )

    def associate(self, tracks: list[Any], detections: list[Any], now: datetime) -> Associated:
        """Append the new state to each track, and return its most probable measurement."""
        found = self._associator.associate(tracks, detections, now) if tracks else {}
        boxes, taken = [], set[int]()
        for track in tracks:
            missed = float(next(each.probability for each in found[track] if not each))
            likely = [(float(each.probability), detections.index(each.measurement)) for each in found[track] if each]
            taken |= {b for probability, b in likely if probability > missed}  # as Stone Soup's mixture tracker
            best = max(likely, default=(0.0, -1))
            boxes.append(best[1] if best[0] > missed else None)
            track.append(self._merged(found[track], now))
        return Associated(boxes, [b for b in range(len(detections)) if b not in taken])

    def _merged(self, hypotheses: Any, now: datetime) -> Any:
        """Return the Gaussian with mean and covariance of the mixture of all updates."""
        from stonesoup.functions import gm_reduce_single
        from stonesoup.types.array import StateVectors
        from stonesoup.types.state import GaussianState

        states = [self._updater.update(each) if each else each.prediction for each in hypotheses]
        weights = np.array([float(each.probability) for each in hypotheses])
        means = StateVectors([state.state_vector for state in states])
        mean, covariance = gm_reduce_single(means, np.stack([state.covar for state in states], axis=2), weights)
        return GaussianState(mean, covariance, timestamp=now)
