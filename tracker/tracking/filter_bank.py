"""One vehicle's bank of filters, by the method of `MmaConfig`: predict, observe, and what it then believes."""

from typing import Protocol

import numpy as np

from tracker.arrays import Floats
from tracker.tracking import mma
from tracker.tracking.filters import FilterConfig, Filters, Motion, bank
from tracker.tracking.imm import FilterpyImm
from tracker.tracking.mma import MmaConfig


class Bank(Protocol):
    """M filters of one vehicle that are told apart by how well they predict."""

    @property
    def probability(self) -> Floats:
        """(M,) equation (12)."""

    @property
    def filters(self) -> Filters:
        """The M filters."""

    @property
    def estimate(self) -> tuple[Floats, Floats]:
        """State (6,) and its covariance (6, 6)."""

    def predict(self, step: Motion) -> None:
        """Move on by one time step."""

    def observe(self, residual: Floats, noise: Floats) -> Floats:
        """Take over a measurement: from each model's prediction to it (M, 2) [m], and its covariance (2, 2) [m^2].

        Returns the covariance (2, 2) that it was given in the end.
        """

    def shift(self, offset: Floats) -> None:
        """Move the tracked point by (2,) [m]: another corner of the same vehicle."""

    def loosen(self, covariance: Floats) -> None:
        """Know the tracked point worse by (2, 2) [m^2]."""


class SelectedBank:
    """The paper's: the filter of the highest score is believed; see `tracker.mma` for whether the filters talk."""

    def __init__(self, filters: Filters, config: MmaConfig) -> None:
        self.filters = filters
        self.probability = mma.initial_probability()
        self._config = config

    @property
    def estimate(self) -> tuple[Floats, Floats]:
        """State (6,) and covariance (6, 6) of the filter of the highest score."""
        best = int(np.argmax(self.probability))
        return self.filters.mean[best], self.filters.covariance[best]

    def predict(self, step: Motion) -> None:
        """Let the filters talk, if they do, and move on by one time step."""
        if self._config.method == "mma":
            chain = mma.transitions(self.filters, step.dt, self._config)
            self.filters, self.probability = mma.mix(self.filters, self.probability, chain)
        self.filters.predict(step.models)

    def observe(self, residual: Floats, noise: Floats) -> Floats:
        """Score the filters by (12) and correct them."""
        evidence, raised = mma.score(self.filters, residual, noise, self._config.tail_dof)
        floor = self._config.probability_floor if self._config.method == "paper" else mma.LEAST_PROBABILITY
        self.probability = mma.update(self.probability, evidence, floor)
        self.filters.correct(residual, raised * noise)
        return raised * noise

    def shift(self, offset: Floats) -> None:
        """Move the tracked point by (2,) [m]."""
        self.filters.mean[:, :2] += offset

    def loosen(self, covariance: Floats) -> None:
        """Know the tracked point worse by (2, 2) [m^2]."""
        self.filters.covariance[:, :2, :2] += covariance


def build(position: Floats, covariance: Floats, filters: FilterConfig, config: MmaConfig) -> Bank:
    """Build the bank of a vehicle that was first seen at (2,) [m] with covariance (2, 2) [m^2]."""
    started = bank(position, covariance, filters)
    return FilterpyImm(started, config) if config.method == "imm" else SelectedBank(started, config)
