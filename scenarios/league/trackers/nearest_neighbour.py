"""Global nearest neighbour with a Kalman filter, by Stone Soup."""

from datetime import datetime
from typing import Any

from luxloop.scenarios.league.trackers.stone_soup import Associated, StoneSoupTracker
from luxloop.tracker.tracker import TrackerConfig


class NearestNeighbour(StoneSoupTracker):
    """Assignment of measurements to tracks with the smallest sum of Mahalanobis distances."""

    def __init__(self, config: TrackerConfig, *arguments: Any, **settings: Any) -> None:
        super().__init__(config, *arguments, **settings)
        from stonesoup.dataassociator.neighbour import GNNWith2DAssignment
        from stonesoup.hypothesiser.distance import DistanceHypothesiser
        from stonesoup.measures import Mahalanobis

        predictor, self._updater = self.filter()
        hypothesiser = DistanceHypothesiser(predictor, self._updater, Mahalanobis(), self.settings.gate_sigma)
        self._associator = GNNWith2DAssignment(hypothesiser)

    def filter(self) -> tuple[Any, Any]:
        """Return the predictor and the updater."""
        from stonesoup.predictor.kalman import KalmanPredictor
        from stonesoup.updater.kalman import KalmanUpdater

        return KalmanPredictor(self.motion), KalmanUpdater(self.measured)

    def associate(self, tracks: list[Any], detections: list[Any], now: datetime) -> Associated:
        """Append the new state to each track, and return which measurement it has."""
        found = self._associator.associate(tracks, detections, now)
        boxes: list[int | None] = []
        for track in tracks:
            hypothesis = found[track]
            track.append(self._updater.update(hypothesis) if hypothesis else hypothesis.prediction)
            boxes.append(detections.index(hypothesis.measurement) if hypothesis else None)
        return Associated(boxes, [b for b in range(len(detections)) if b not in boxes])
