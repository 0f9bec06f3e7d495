"""Trackers of Stone Soup: constant velocity, linear measurements of the centre of a vehicle.

- `NearestNeighbour`: global nearest neighbour with a Kalman filter
- `ParticleFilter`: the same association with a particle filter
- `JointProbabilistic`: joint probabilistic data association (JPDA) with a Kalman filter
- `MultiHypothesis`: multi-frame assignment (MFA) of hypotheses with Kalman filters

Stone Soup's own tracker classes keep tracks and detections in sets, whose order changes from process to process.
This loop passes lists, so that equal scans give equal tracks.

`stonesoup.dataassociator.mfa` solves the assignment by ortools, whose protobuf excludes that of commonroad-io. Here
scipy's integer program solves it: one hypothesis per track, each measurement of the last scans in one track at most,
the smallest sum of costs. Then hypotheses that contradict the best ones at the beginning of the window are removed
(N-scan pruning; Blackman 2004, IEEE AES Magazine 19, 5).
"""

from abc import ABC, abstractmethod
from collections.abc import Hashable
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any, ClassVar, NamedTuple

import numpy as np
import scipy
from scipy.optimize import Bounds, LinearConstraint, milp

from luxloop.scenarios.league.trackers.track_book import TrackBook
from luxloop.scenarios.league.trackers.vehicle_boxes import MakeDetector, VehicleBoxes
from luxloop.tracker.arrays import Floats
from luxloop.tracker.detection.detector import Detector
from luxloop.tracker.records import Tracks
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import TrackerConfig

EPOCH = datetime(2000, 1, 1)
SPEED_STD_MPS = 10.0
"""Standard deviation of the velocity of a new track, per axis [m/s]."""
POSITIONS, VELOCITIES = [0, 2], [1, 3]
"""Places in the state x, vx, y, vy."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """Settings that all trackers of Stone Soup have."""

    acceleration: float = 5.0
    """Spectral density of the white acceleration [m^2/s^3]."""
    position_std_m: float = 0.4
    """Standard deviation of a measured centre, per axis [m]."""
    gate_sigma: float = 4.0
    """Largest distance of a measurement to its prediction [standard deviations]."""
    confirm_hits: int = 4
    """As for `TrackBook`."""
    coast_s: float = 1.0
    """As for `TrackBook`."""


class Associated(NamedTuple):
    """Boxes by track (an index, or None without a measurement), and boxes that may start tracks."""

    box_of_track: list[int | None]
    free: list[int]


class StoneSoupTracker(ABC):
    """Tracker whose filter and association are Stone Soup's."""

    settings_type: ClassVar[type[Settings]] = Settings

    def __init__(self, config: TrackerConfig, make_detector: MakeDetector = Detector, **settings: Any) -> None:
        from stonesoup.models.measurement.linear import LinearGaussian
        from stonesoup.models.transition.linear import CombinedLinearGaussianTransitionModel, ConstantVelocity

        self.settings = self.settings_type(**settings)
        self._boxes = VehicleBoxes(config, make_detector)
        self._book = TrackBook(self.settings.confirm_hits, self.settings.coast_s)
        axis = [ConstantVelocity(self.settings.acceleration) for _ in range(2)]
        self.motion = CombinedLinearGaussianTransitionModel(axis, seed=0)
        noise = self.settings.position_std_m**2 * np.eye(2)
        self.measured = LinearGaussian(ndim_state=4, mapping=POSITIONS, noise_covar=noise)
        self._tracks: list[Any] = []

    @abstractmethod
    def associate(self, tracks: list[Any], detections: list[Any], now: datetime) -> Associated:
        """Append the new state to each track, and return which measurement it has."""

    def first_state(self, center: Floats, now: datetime) -> Any:
        """Return the state of a new track at `center` (2,)."""
        from stonesoup.types.state import GaussianState

        variance = np.diag([self.settings.position_std_m**2, SPEED_STD_MPS**2] * 2)
        return GaussianState([[center[0]], [0.0], [center[1]], [0.0]], variance, timestamp=now)

    def mean(self, track: Any) -> Floats:
        """Return the reported state (4,) of a track."""
        return np.asarray(track.state.mean, dtype=np.float64).reshape(-1)

    def step(self, scan: Scan) -> Tracks:
        """Return the tracks of a scan."""
        from stonesoup.types.detection import Detection
        from stonesoup.types.track import Track

        readings, now = self._boxes.step(scan), EPOCH + timedelta(seconds=scan.time)
        detections = [Detection(c[:, None], timestamp=now, measurement_model=self.measured) for c in readings.center]
        found = self.associate(self._tracks, detections, now)
        for track, b in zip(self._tracks, found.box_of_track, strict=True):
            if b is not None:
                self._book.see(track.id, readings, b, scan.time, self.mean(track)[VELOCITIES])
        self._tracks = [track for track in self._tracks if not self._book.ends(track.id, scan.time)]
        for b in found.free:
            self._tracks.append(Track([self.first_state(readings.center[b], now)]))
            self._book.start(self._tracks[-1].id, readings, b, scan.time, float(scan.ego_pose_odom[2]))
        keys: list[Hashable] = [track.id for track in self._tracks]
        at, speed = ([self.mean(track)[part] for track in self._tracks] for part in (POSITIONS, VELOCITIES))
        return self._book.report(keys, at, speed, scan.time)


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


@dataclass(frozen=True, slots=True, kw_only=True)
class ParticleSettings(Settings):
    """Settings of the particle filter."""

    particles: int = 500


class ParticleFilter(NearestNeighbour):
    """Bootstrap filter with systematic resampling; all draws follow from a fixed seed."""

    settings_type: ClassVar[type[Settings]] = ParticleSettings

    def filter(self) -> tuple[Any, Any]:
        """Return the predictor and the updater."""
        from stonesoup.predictor.particle import ParticlePredictor
        from stonesoup.resampler.particle import SystematicResampler
        from stonesoup.updater.particle import ParticleUpdater

        rng = self._rng = np.random.default_rng(0)

        class SeededResampler(SystematicResampler):  # type: ignore[misc]
            """Stone Soup's resampler draws from numpy's global generator; this one from the tracker's own."""

            def resample(self, particles: Any, nparts: int | None = None) -> Any:
                count = nparts or len(particles)
                share = np.exp(particles.log_weight - np.max(particles.log_weight))
                places = (rng.random() + np.arange(count)) / count * share.sum()
                kept = particles[np.minimum(np.searchsorted(np.cumsum(share), places), len(share) - 1)]
                kept.log_weight = np.full(count, -np.log(count))
                return kept

        return ParticlePredictor(self.motion), ParticleUpdater(self.measured, SeededResampler())

    def first_state(self, center: Floats, now: datetime) -> Any:
        """Return the particles of a new track at `center` (2,)."""
        from stonesoup.types.array import StateVectors
        from stonesoup.types.state import ParticleState

        own = self.settings
        assert isinstance(own, ParticleSettings)
        std = np.array([own.position_std_m, SPEED_STD_MPS] * 2)
        drawn = np.array([center[0], 0.0, center[1], 0.0])[:, None] + std[:, None] * self._rng.standard_normal(
            (4, own.particles)
        )
        weight = np.full(own.particles, -np.log(own.particles))
        return ParticleState(StateVectors(drawn), log_weight=weight, timestamp=now)


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
