"""Kinematic state of the tracked corner of one vehicle."""

import math
from dataclasses import replace

import numpy as np

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.geometry import mahalanobis, rotate_one
from luxloop.tracker.records import NO_MODEL
from luxloop.tracker.tracking import orientation
from luxloop.tracker.tracking.corner_error import CornerError
from luxloop.tracker.tracking.filter_bank import FilterBank
from luxloop.tracker.tracking.filters import ORDERS, Motion, moved
from luxloop.tracker.tracking.independent_filters import IndependentFilters
from luxloop.tracker.tracking.orientation import Course
from luxloop.tracker.tracking.track_config import TrackConfig
from luxloop.tracker.tracking.track_observation import TrackObservation


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
        self.error = CornerError(first, heading, unseen, config.corner)
        """Time-correlated error of the position."""
        self._orientation = config.orientation
        self._models = config.filters.models
        self._stationary = self._models.index("stationary") if "stationary" in self._models else NO_MODEL
        self._filters = config.filters
        self._first_offset = first.time_offset

    @property
    def model(self) -> int:
        """Index of the selected model: the highest score of (12)."""
        return self.bank.model

    @property
    def model_name(self) -> str:
        """Name of the selected model."""
        return self._models[self.model]

    @property
    def stationary(self) -> bool:
        """True if the stationary model is selected."""
        return self.model == self._stationary

    @property
    def selected(self) -> Floats:
        """(2,) position by the selected model [m]."""
        return self.bank.filters.mean[self.model, :2]

    @property
    def position(self) -> Floats:
        """(2,) position [m]."""
        return self.bank.estimate[0][:2].copy()

    @property
    def velocity(self) -> Floats:
        """(2,) velocity [m/s], zero if the stationary model is selected."""
        return np.zeros(2) if self.stationary else self.bank.estimate[0][2:4]

    @property
    def speed(self) -> float:
        """Root mean square of the speed [m/s], which includes its uncertainty."""
        mean, covariance = self.bank.estimate
        x, y = (0.0, 0.0) if self.stationary else mean[2:4].tolist()
        return math.sqrt(x * x + y * y + 0.5 * (covariance.item(2, 2) + covariance.item(3, 3)))

    def course(self, to_axle: complex, yaw_rate: float, variance: float) -> Course | None:
        """Direction of motion of the rear axle of a moving vehicle, None for one that may be stationary.

        The corners of a turning vehicle move across its heading, the rear axle does not.

        Parameters
        ----------
        to_axle
            Vector from the tracked corner to the middle of the rear axle, odometry frame [m].
        yaw_rate, variance
            [rad/s], [rad^2/s^2].
        """
        mean, covariance = self.bank.estimate
        lever, ((xx, xy), (_, yy)) = 1j * to_axle, covariance[2:4, 2:4].tolist()
        x, y = lever.real, lever.imag
        of_axle = xx + variance * x * x, xy + variance * x * y, yy + variance * y * y
        return orientation.course(complex(*mean[2:4].tolist()) + yaw_rate * lever, of_axle, self._orientation)

    def offset_covariance(self, heading: float) -> Floats:
        """(2, 2) covariance of the time-correlated error, odometry frame [m^2]."""
        return self.error.covariance(heading)

    def covariance(self, heading: float) -> Floats:
        """(2, 2) covariance of the position [m^2]."""
        return np.asarray(self.bank.estimate[1][:2, :2] + self.offset_covariance(heading))

    def predict(self, motion: Motion, of_bank: Motion) -> None:
        """Move on by one time step: the independent filters by `motion`, and the bank by its own one."""
        self.bank.predict(of_bank)
        self.independent.predict(motion.models)

    def start(self, seen: TrackObservation, since_s: float) -> TrackObservation:
        """Admit the speed that the second observation shows, one scan after the first, `since_s`.

        The prior of the velocity has a mean of zero. Where the vehicle moved by more than two of its standard
        deviations explain, the variance along that motion becomes the square of the speed. Both boxes were at their
        places at their own times: the returned observation, and the track, are those at the times of the scans.
        """
        moved = seen.misfit[self.model]
        elapsed = since_s + seen.time_offset - self._first_offset
        if elapsed <= 0.0 or np.hypot(*moved) <= 2.0 * self._filters.initial_speed_std_mps * elapsed:
            return seen
        velocity = moved / elapsed
        self.shift(-self._first_offset * velocity, yaw_rate=0.0)
        spread = np.outer(velocity, velocity)
        growth = np.kron([[since_s**2, since_s], [since_s, 1.0]], spread)
        moves = np.array([ORDERS[name] > 1 for name in self._models])
        each = moves[:, None, None] * growth
        self.bank.inflate(each)
        self.independent.inflate(each)
        return replace(seen, misfit=seen.misfit + (self._first_offset - seen.time_offset) * velocity)

    def density(self, seen: TrackObservation, heading: float) -> float:
        """Return the predicted density of an observation at its place, over all models [1/m^2]."""
        innovation = self.bank.filters.covariance[:, :2, :2] + seen.covariance + self.offset_covariance(heading)
        squared, determinant = mahalanobis(seen.misfit, innovation)
        each = np.exp(-0.5 * squared) / (2.0 * np.pi * np.sqrt(determinant))
        return float(self.bank.probability @ each)

    def observe(self, seen: TrackObservation, heading: float) -> None:
        """Update the filters and the time-correlated error by one observation."""
        measured = self.selected + seen.misfit[self.model]
        released = self.error.released(seen, heading)
        self.bank.inflate(released)
        self.independent.inflate(released)
        covariance = self.bank.observe(seen.misfit, seen.covariance)
        self.error.observe(seen.exact, covariance, heading)
        self.independent.observe(measured, covariance)

    def shift(self, offset: Floats, yaw_rate: float) -> None:
        """Track another point of a vehicle with a yaw rate [rad/s], (2,) [m] away from the current one."""
        change = moved(offset, yaw_rate)
        self.bank.shift(change)
        self.independent.shift(change)

    def change_corner(self, sign: Ints, size: Floats, unseen: Floats, heading: float, yaw_rate: float) -> Floats:
        """Track another corner of a vehicle of size (2,) [m] and yaw rate [rad/s]; return the vector (2,) to it [m]."""
        offset = rotate_one(0.5 * (sign - self.sign) * size, heading)
        self.shift(offset, yaw_rate)
        self.error.change_corner(sign != self.sign, unseen)
        self.sign = sign
        return offset

    def turn(self, quarters: int) -> None:
        """Identify the same corner in a frame turned by `quarters`."""
        self.sign = orientation.turn_sign(self.sign, quarters)
        self.error.turn(quarters)
