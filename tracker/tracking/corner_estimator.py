"""Kinematic state of the tracked corner of one vehicle."""

import numpy as np

from tracker.arrays import Floats, Ints
from tracker.geometry import rotate
from tracker.tracking import orientation
from tracker.tracking.corner_error import CornerError
from tracker.tracking.filter_bank import FilterBank
from tracker.tracking.filters import Motion
from tracker.tracking.independent_filters import IndependentFilters
from tracker.tracking.track_config import TrackConfig
from tracker.tracking.track_observation import TrackObservation


class CornerEstimator:
    """Position and motion of the tracked corner: filter bank, independent filters and time-correlated error.

    Parameters
    ----------
    position
        (2,) corner to track, odometry frame [m].
    first
        First observation.
    heading
        Heading of the vehicle [rad].
    unseen
        (2,) unseen part of length and width [m].
    bank
        Filter bank at `position`.
    """

    def __init__(
        self,
        position: Floats,
        first: TrackObservation,
        heading: float,
        unseen: Floats,
        config: TrackConfig,
        bank: FilterBank,
    ) -> None:
        self.bank = bank
        self.independent = IndependentFilters(position, first.covariance, config.filters)
        self.sign = first.corner_sign
        """(2,) signs of the corner in the vehicle's frame."""
        self._error = CornerError(first, heading, unseen, config.corner)
        self._orientation = config.orientation
        self._models = config.filters.models

    @property
    def model(self) -> int:
        """Index of the selected model: the highest score of (12)."""
        return int(np.argmax(self.bank.probability))

    @property
    def model_name(self) -> str:
        """Name of the selected model."""
        return self._models[self.model]

    @property
    def position(self) -> Floats:
        """(2,) position [m]."""
        return self.bank.estimate[0][:2].copy()

    @property
    def velocity(self) -> Floats:
        """(2,) velocity [m/s], zero if the stationary model is selected."""
        return np.zeros(2) if self.model_name == "stationary" else self.bank.estimate[0][2:4]

    @property
    def course(self) -> float | None:
        """Direction of motion [rad], None for a vehicle that may be stationary."""
        if self.model_name == "stationary":
            return None
        mean, covariance = self.bank.estimate
        return orientation.course(mean[2:4], covariance[2:4, 2:4], self._orientation)

    def offset_covariance(self, heading: float) -> Floats:
        """(2, 2) covariance of the time-correlated error, odometry frame [m^2]."""
        return self._error.covariance(heading)

    def covariance(self, heading: float) -> Floats:
        """(2, 2) covariance of the position [m^2]."""
        return np.asarray(self.bank.estimate[1][:2, :2] + self.offset_covariance(heading))

    def predict(self, motion: Motion) -> None:
        """Move on by one time step."""
        self.bank.predict(motion)
        self.independent.predict(motion.models)

    def observe(self, seen: TrackObservation, heading: float) -> None:
        """Update the filters and the time-correlated error by one observation."""
        measured = self.bank.filters.mean[self.model, :2] + seen.misfit[self.model]
        released = self._error.released(seen, heading)
        self.bank.inflate(released)
        self.independent.inflate(released)
        covariance = self.bank.observe(seen.misfit, seen.covariance)
        self._error.observe(seen.exact, covariance, heading)
        self.independent.observe(measured, covariance)

    def shift(self, offset: Floats) -> None:
        """Track another point, (2,) [m] away from the current one."""
        self.bank.shift(offset)
        self.independent.shift(offset)

    def change_corner(self, sign: Ints, size: Floats, unseen: Floats, heading: float) -> Floats:
        """Track another corner of a vehicle of size (2,) [m]; return the vector (2,) to it [m]."""
        offset = rotate(0.5 * (sign - self.sign) * size, heading)
        self.shift(offset)
        self._error.change_corner(sign != self.sign, unseen)
        self.sign = sign
        return offset

    def turn(self, quarters: int) -> None:
        """Identify the same corner in a frame turned by `quarters`."""
        self.sign = orientation.turn_sign(self.sign, quarters)
        self._error.turn(quarters)
