"""Filter bank of one vehicle: prediction, correction and model selection."""

from typing import Protocol

from luxloop.tracker.arrays import Floats
from luxloop.tracker.tracking import mma
from luxloop.tracker.tracking.filters import Filters, Motion
from luxloop.tracker.tracking.mma import MmaConfig


class FilterBank(Protocol):
    """M filters of one vehicle, weighted by how well they predict."""

    @property
    def probability(self) -> Floats:
        """(M,) model probabilities, equation (12)."""

    @property
    def model(self) -> int:
        """Index of the selected model: the highest probability."""

    @property
    def weights(self) -> Floats:
        """(M,) shares of the models in a prediction, which sum to 1."""

    @property
    def mode_time_s(self) -> float:
        """Mean time in a mode [s]; infinite for a vehicle that does not change its mode."""

    @property
    def filters(self) -> Filters:
        """The M filters."""

    @property
    def estimate(self) -> tuple[Floats, Floats]:
        """State (6,) and its covariance (6, 6)."""

    def predict(self, motion: Motion) -> None:
        """Move on by one time step."""

    def observe(self, residual: Floats, noise: Floats) -> Floats:
        """Update by a measurement.

        Parameters
        ----------
        residual
            (M, 2) measured minus predicted corner of each model [m].
        noise
            (2, 2) covariance of the measurement [m^2].

        Returns
        -------
        Floats
            (2, 2) covariance that the update used [m^2].
        """

    def shift(self, change: Floats) -> None:
        """Change the state by (6,), to that of another point of the same vehicle."""

    def inflate(self, covariance: Floats) -> None:
        """Add (n, n), or one (n, n) per model, to the covariance of the first n states."""


class ScoredFilters:
    """Batch of filters with model probabilities by (12), the common part of the banks that run on `Filters`.

    Parameters
    ----------
    filters
        The M filters, all equally probable.
    tail_dof
        As `MmaConfig.tail_dof`.
    probability_floor
        Lower limit of a probability.
    """

    def __init__(self, filters: Filters, tail_dof: float, probability_floor: float) -> None:
        self.filters = filters
        self.probability = mma.initial_probability(len(filters.mean))
        self.tail_dof = tail_dof
        self.floor = probability_floor

    @property
    def probability(self) -> Floats:
        """(M,) model probabilities, equation (12)."""
        return self._probability

    @probability.setter
    def probability(self, probability: Floats) -> None:
        values = probability.tolist()
        self._probability, self.model = probability, values.index(max(values))

    @property
    def weights(self) -> Floats:
        """(M,) model probabilities."""
        return self.probability

    def observe(self, residual: Floats, noise: Floats) -> Floats:
        """Score the filters by (12) and correct them; see `FilterBank.observe`."""
        evidence, scale = mma.score(self.filters, residual, noise, self.tail_dof)
        self.probability = mma.update(self.probability, evidence, self.floor)
        self.filters.correct(residual, scale * noise)
        return scale * noise

    def shift(self, change: Floats) -> None:
        """Change the state by (6,), to that of another point of the same vehicle."""
        self.filters.mean += change

    def inflate(self, covariance: Floats) -> None:
        """Add (n, n), or one (n, n) per model, to the covariance of the first n states."""
        n = covariance.shape[-1]
        self.filters.covariance[:, :n, :n] += covariance


class SelectedBank(ScoredFilters):
    """Filter bank that mixes its filters and reports the one of the highest score.

    The prediction is the mean over the modes, because the vehicle may be in another one, or change to it.
    """

    def __init__(self, filters: Filters, config: MmaConfig) -> None:
        super().__init__(filters, config.tail_dof, mma.LEAST_PROBABILITY)
        self.config = config

    @property
    def mode_time_s(self) -> float:
        """Mean time in a mode [s]."""
        return self.config.mode_time_s

    @property
    def estimate(self) -> tuple[Floats, Floats]:
        """State (6,) and covariance (6, 6) of the filter of the highest score."""
        return self.filters.mean[self.model], self.filters.covariance[self.model]

    def predict(self, motion: Motion) -> None:
        """Mix the filters and move on by one time step."""
        chain = mma.transitions(self.filters, motion.dt, self.config, motion.names)
        self.filters, self.probability = mma.mix(self.filters, self.probability, chain)
        self.filters.predict(motion.models)
