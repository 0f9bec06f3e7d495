"""Model selection: how the filter banks of all tracks mix, score and select their motion models.

A bank is a row of the table: M filters and their probabilities. Each selection works on all rows at once. It writes the
reported state into the columns `estimate` and `estimate_covariance`.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

import numpy as np

from luxloop.arrays import Floats, Ints
from luxloop.tracker.tracking import mma
from luxloop.tracker.tracking.filters import STATE_DIM, Step
from luxloop.tracker.tracking.mma import MmaConfig
from luxloop.tracker.tracking.track_table import TrackTable

if TYPE_CHECKING:
    from filterpy.kalman import IMMEstimator, KalmanFilter


class ModelSelection(Protocol):
    """Filter banks of all tracks: prediction, correction and selection of a motion model."""

    @property
    def mode_time_s(self) -> float:
        """Mean time in a mode [s]; infinite for vehicles that do not change their mode."""

    def weights(self, tracks: TrackTable) -> Floats:
        """(T, M) fractions of the models in a prediction, which sum to 1."""

    def predict(self, tracks: TrackTable, step: Step, dt: float) -> None:
        """Move all banks on by `dt` [s]; the step has (M, 6, 6) matrices, or (T * M, 6, 6) for motions that differ."""

    def correct(self, tracks: TrackTable, rows: Ints, innovation: Floats, noise: Floats) -> Floats:
        """Update the banks of `rows` (P,) by measurements of their corners.

        Parameters
        ----------
        innovation
            (P, M, 2) measured minus predicted corner of each model [m].
        noise
            (P, 2, 2) covariance of the measurement [m^2].

        Returns
        -------
        Floats
            (P, 2, 2) covariance that the update used [m^2].
        """

    def summarise(self, tracks: TrackTable, rows: Ints) -> None:
        """Write the reported states of `rows` after a change of their filters."""


class SelectedModel:
    """Multiple-model association: mixes the filters of a bank and reports the one of the highest probability.

    The prediction is the mean over the modes, because the vehicle may be in another one, or change to it.
    """

    def __init__(self, config: MmaConfig) -> None:
        self.config = config
        self.floor = mma.LEAST_PROBABILITY
        """Lower limit of a model probability."""

    @property
    def mode_time_s(self) -> float:
        """Mean time in a mode [s]."""
        return self.config.mode_time_s

    def weights(self, tracks: TrackTable) -> Floats:
        """(T, M) model probabilities."""
        return tracks.probability

    def predict(self, tracks: TrackTable, step: Step, dt: float) -> None:
        """Mix the filters and move on by one time step."""
        changes = mma.changes(dt, self.config, tracks.models)
        states = tracks.mean, tracks.covariance, tracks.probability
        moved = mma.predict_banks(*states, step.transition, step.noise, changes)
        tracks.mean, tracks.covariance, tracks.probability = moved
        self.summarise(tracks, np.arange(len(tracks)))

    def correct(self, tracks: TrackTable, rows: Ints, innovation: Floats, noise: Floats) -> Floats:
        """Score the filters by (12) and correct them; see `ModelSelection.correct`."""
        states = tracks.mean[rows], tracks.covariance[rows], tracks.probability[rows]
        *corrected, used = mma.correct_banks(*states, innovation, noise, self.config.tail_dof, self.floor)
        tracks.mean[rows], tracks.covariance[rows], tracks.probability[rows] = corrected
        self.summarise(tracks, rows)
        return np.asarray(used)

    def summarise(self, tracks: TrackTable, rows: Ints) -> None:
        """Report the filter of the highest probability."""
        model = tracks.probability[rows].argmax(axis=1)
        tracks.estimate[rows] = tracks.mean[rows, model]
        tracks.estimate_covariance[rows] = tracks.covariance[rows, model]


class AverageModel(SelectedModel):
    """Independent filters without mixing, averaged by their probabilities (Magill 1965)."""

    def __init__(self, config: MmaConfig) -> None:
        super().__init__(config)
        self.floor = mma.PROBABILITY_FLOOR

    @property
    def mode_time_s(self) -> float:
        """Infinite: a vehicle stays in its mode."""
        return np.inf

    def predict(self, tracks: TrackTable, step: Step, dt: float) -> None:
        """Move on by one time step."""
        del dt
        tracks.mean, tracks.covariance = mma.move(tracks.mean, tracks.covariance, step.transition, step.noise)
        self.summarise(tracks, np.arange(len(tracks)))

    def summarise(self, tracks: TrackTable, rows: Ints) -> None:
        """Report the mean and the covariance of the mixture."""
        probability = tracks.probability[rows]
        one = np.ones((*probability.shape, 1))
        mean, covariance, _ = mma.mix(tracks.mean[rows], tracks.covariance[rows], probability, one)
        tracks.estimate[rows], tracks.estimate_covariance[rows] = mean[:, 0], covariance[:, 0]


class PaperModel(SelectedModel):
    """The paper's bank: filterpy's independent filters by (6) to (9), scored by (10) to (12), the best reported."""

    def __init__(self, config: MmaConfig) -> None:
        super().__init__(config)
        self.floor = mma.PROBABILITY_FLOOR

    @property
    def mode_time_s(self) -> float:
        """Infinite: a vehicle stays in its mode."""
        return np.inf

    def weights(self, tracks: TrackTable) -> Floats:
        """(T, M) one for the filter of the highest score."""
        return np.asarray(np.arange(len(tracks.models)) == tracks.model[:, None], dtype=np.float64)

    def predict(self, tracks: TrackTable, step: Step, dt: float) -> None:
        """Move on by one time step."""
        del dt
        kf = kalman_filter()
        for k, (t, m) in enumerate(np.ndindex(*tracks.probability.shape)):
            load(kf, tracks, t, m)
            kf.predict(F=step.transition[k % len(step.transition)], Q=step.noise[k % len(step.noise)])
            tracks.mean[t, m], tracks.covariance[t, m] = kf.x, kf.P
        self.summarise(tracks, np.arange(len(tracks)))

    def correct(self, tracks: TrackTable, rows: Ints, innovation: Floats, noise: Floats) -> Floats:
        """Score the filters by (12) and correct each by its own innovation; see `ModelSelection.correct`."""
        evidence, scale = mma.score(tracks.covariance[rows], innovation, noise, self.config.tail_dof)
        tracks.probability[rows] = mma.update(tracks.probability[rows], evidence, self.floor)
        used, kf = scale[:, None, None] * noise, kalman_filter()
        for p, t in enumerate(rows.tolist()):
            for m in range(len(tracks.models)):
                load(kf, tracks, t, m)
                kf.update(kf.x[:2] + innovation[p, m], R=used[p])
                tracks.mean[t, m], tracks.covariance[t, m] = kf.x, kf.P
        self.summarise(tracks, rows)
        return np.asarray(used)


class InteractingModels:
    """filterpy's interacting multiple model, which reports the mean of all models (Blom and Bar-Shalom 1988)."""

    def __init__(self, config: MmaConfig) -> None:
        self.config = config

    @property
    def mode_time_s(self) -> float:
        """Mean time in a mode [s]."""
        return self.config.mode_time_s

    def weights(self, tracks: TrackTable) -> Floats:
        """(T, M) model probabilities."""
        return tracks.probability

    def predict(self, tracks: TrackTable, step: Step, dt: float) -> None:
        """Mix the models and move on by one time step."""
        changes = mma.changes(dt, self.config, tracks.models)
        chains = mma.transitions(tracks.mean, tracks.covariance, changes)
        models = len(tracks.models)
        for t in range(len(tracks)):
            imm = estimator(tracks, t)
            # filterpy uses the last scan's M; here it depends on the state, and on the time without observations.
            imm.M = chains[t]
            imm.cbar = imm.mu @ imm.M
            imm.omega = imm.mu[:, None] * imm.M / imm.cbar
            imm.mu = imm.cbar
            for m, kf in enumerate(imm.filters):
                k = t * models + m
                kf.F, kf.Q = step.transition[k % len(step.transition)], step.noise[k % len(step.noise)]
            imm.predict()
            store(imm, tracks, t)

    def correct(self, tracks: TrackTable, rows: Ints, innovation: Floats, noise: Floats) -> Floats:
        """Update by the innovation of the likeliest model: filterpy passes the same measurement to all models."""
        _, scale = mma.score(tracks.covariance[rows], innovation, noise, self.config.tail_dof)
        used = scale[:, None, None] * noise
        for p, t in enumerate(rows.tolist()):
            imm, best = estimator(tracks, t), int(tracks.probability[t].argmax())
            imm.cbar = imm.mu  # those of the prediction
            for kf in imm.filters:
                kf.R = used[p]
            imm.update(imm.filters[best].x[:2] + innovation[p, best])
            store(imm, tracks, t)
        return np.asarray(used)

    def summarise(self, tracks: TrackTable, rows: Ints) -> None:
        """Report the mean of the models of new tracks; filterpy writes that of the others."""
        for t in rows.tolist():
            if not tracks.estimate_covariance[t].any():
                imm = estimator(tracks, t)
                tracks.estimate[t], tracks.estimate_covariance[t] = imm.x, imm.P


def kalman_filter() -> "KalmanFilter":
    """Return filterpy's Kalman filter with x and y as measurement."""
    from filterpy.kalman import KalmanFilter  # imports scipy.stats, which takes half a second

    kf = KalmanFilter(dim_x=STATE_DIM, dim_z=2)
    kf.H = np.eye(2, STATE_DIM)
    return kf


def load(kf: "KalmanFilter", tracks: TrackTable, t: int, m: int) -> None:
    """Give a filter the state of model `m` of track `t`."""
    kf.x, kf.P = tracks.mean[t, m].copy(), tracks.covariance[t, m].copy()


def estimator(tracks: TrackTable, t: int) -> "IMMEstimator":
    """Return filterpy's estimator with the filters and the probabilities of a track."""
    from filterpy.kalman import IMMEstimator

    filters = [kalman_filter() for _ in tracks.models]
    for m, kf in enumerate(filters):
        load(kf, tracks, t, m)
    # M[i, j] is the probability of the change from i to j; filterpy's docstring says the opposite.
    imm = IMMEstimator(filters, tracks.probability[t], np.eye(len(filters)))
    imm.mu = tracks.probability[t].copy()  # filterpy scales them once more
    return imm


def store(imm: "IMMEstimator", tracks: TrackTable, t: int) -> None:
    """Write the filters, the probabilities and the mean of a track."""
    tracks.mean[t], tracks.covariance[t] = [kf.x for kf in imm.filters], [kf.P for kf in imm.filters]
    tracks.probability[t], tracks.estimate[t], tracks.estimate_covariance[t] = imm.mu, imm.x, imm.P


SELECTIONS: dict[str, Callable[[MmaConfig], ModelSelection]] = {
    "mma": SelectedModel,
    "imm": InteractingModels,
    "average": AverageModel,
    "paper": PaperModel,
}
"""Model selection of each `MmaConfig.method`."""


def model_selection(config: MmaConfig) -> ModelSelection:
    """Return the model selection of `MmaConfig.method`."""
    return SELECTIONS[config.method](config)
