"""One tracked vehicle: its filters, its corner, its size and its life."""

from dataclasses import dataclass

import numpy as np

from tracker.arrays import Floats, Ints
from tracker.bounds import require_within
from tracker.geometry import QUARTER, rotate, spread, variance_along, wrap
from tracker.records import Status
from tracker.tracking import extent, filter_bank, orientation
from tracker.tracking.confirmation import Confirmation, TrackLifeConfig
from tracker.tracking.extent import ExtentConfig
from tracker.tracking.filters import FilterConfig, Motion, heading_filter
from tracker.tracking.footprint import Footprint
from tracker.tracking.independent_filters import IndependentFilters
from tracker.tracking.mma import CA, STATIONARY, MmaConfig
from tracker.tracking.orientation import OrientationConfig
from tracker.tracking.track_observation import TrackObservation


@dataclass(frozen=True, slots=True)
class CornerConfig:
    """How far the tracked corner may be off for as long as it is seen in the same way.

    Such an error is no noise: the filters follow it, and no number of observations averages it away. It is therefore
    kept out of their gains and added to what they report (the "consider" part of Schmidt 1966, for a slow error). An
    end that is seen is off by what its scan is off by, for the beams meet the same places again in the next one.
    """

    known_std_m: float = 0.15
    """An end that is a known side length away from one that is seen [m]."""
    unseen_share: float = 0.5
    """An end that was never seen: this share of what the prior adds to what is seen of the side."""

    def __post_init__(self) -> None:
        require_within(self, 0.0, 1e3, "known_std_m", "unseen_share")


@dataclass(frozen=True, slots=True)
class TrackConfig:
    """All that one track needs to know."""

    filters: FilterConfig
    mma: MmaConfig
    extent: ExtentConfig
    orientation: OrientationConfig
    corner: CornerConfig
    life: TrackLifeConfig


class Track:
    """A vehicle followed by one of its corners, in the odometry frame."""

    def __init__(
        self, track_id: int, position: Floats, first: TrackObservation, forward: float, config: TrackConfig
    ) -> None:
        self.id = track_id
        self.status = Status.TENTATIVE
        self.bank = filter_bank.build(position, first.covariance, config.filters, config.mma)
        self.alone = IndependentFilters(position, first.covariance, config.filters)
        self.corner_sign = first.corner_sign
        self.hits = 1
        self.unseen_s = 0.0
        self._config = config
        self._heading = heading_filter(first.heading, first.heading_variance, config.filters)
        self._forward = forward
        self._oriented = False
        self._oriented_hits = 0
        self._votes = 0
        self._turn_from = position
        self._heading_rejections = 0
        self._whole_sights = np.zeros(2, dtype=np.int64)
        """(2,) how often length and width were seen from end to end."""
        self._resize(first.size)
        self._offset_variance = np.where(
            first.exact, variance_along(first.covariance, self.heading), self._end_variance
        )
        self._belief = Confirmation(config.life, config.extent, self.footprint)
        self._belief.see(first, self.seen_size)

    @property
    def heading(self) -> float:
        """Heading [rad]."""
        return float(self._heading.mean[0, 0])

    @property
    def yaw_state(self) -> tuple[Floats, Floats]:
        """Heading and yaw rate (2,), and their covariance (2, 2)."""
        return self._heading.mean[0], self._heading.covariance[0]

    @property
    def known_size(self) -> Floats:
        """(2,) how much of length and width is known to be there, from the tracked corner on [m]."""
        return extent.known(self.seen_size, self.size, self._config.extent)

    @property
    def model(self) -> int:
        """The selected model: the highest score of (12)."""
        return int(np.argmax(self.bank.probability))

    @property
    def offset_covariance(self) -> Floats:
        """(2, 2) of the error that lasts, odometry frame [m^2]."""
        return spread(self._offset_variance, self.heading)

    @property
    def covariance(self) -> Floats:
        """(2, 2) of the tracked corner [m^2]."""
        return np.asarray(self.bank.estimate[1][:2, :2] + self.offset_covariance)

    @property
    def seen(self) -> bool:
        """Whether the track was updated in this frame."""
        return self.unseen_s == 0.0

    @property
    def sure(self) -> bool:
        """Whether the track is confirmed and was updated in this frame."""
        return self.status is Status.CONFIRMED and self.seen

    @property
    def position(self) -> Floats:
        """(2,) tracked corner [m]."""
        return self.bank.estimate[0][:2].copy()

    @property
    def velocity(self) -> Floats:
        """(2,) [m/s], none of a vehicle that stands."""
        return np.zeros(2) if self.model == STATIONARY else self.bank.estimate[0][2:4]

    @property
    def course(self) -> float | None:
        """Direction of motion [rad], None for a vehicle that may be standing."""
        if self.model == STATIONARY:
            return None
        mean, covariance = self.bank.estimate
        return orientation.course(mean[2:4], covariance[2:4, 2:4], self._config.orientation)

    def predict(self, step: Motion) -> None:
        """Move on by one time step; the track counts as unseen until it is updated, and dies of waiting too long.

        Only the constant acceleration model lets a vehicle turn: the others set its yaw rate to zero.
        """
        if self.model != CA:
            self._heading.mean[0, 1] = 0.0
        self.bank.predict(step)
        self.alone.predict(step.models)
        self._heading.predict(step.heading)
        self.unseen_s += step.dt
        life = self._config.life
        if self.unseen_s > (life.tentative_coast_s if self.status is Status.TENTATIVE else life.coast_s):
            self.status = Status.DEAD

    def update(self, seen: TrackObservation) -> None:
        """Take over one observation."""
        measured = self.bank.filters.mean[self.model, :2] + seen.misfit[self.model]
        self._loosen(seen)
        covariance = self.bank.observe(seen.misfit, seen.covariance)
        guessed = np.maximum(self._offset_variance, self._config.corner.known_std_m**2)
        self._offset_variance = np.where(seen.exact, variance_along(covariance, self.heading), guessed)
        self.alone.observe(measured, covariance)
        self._update_heading(seen.heading, seen.heading_variance)
        self.hits += 1
        self._oriented_hits += self._oriented
        self.unseen_s = 0.0
        longer = extent.remember(self.seen_size, seen.size, seen.whole, self._whole_sights, self._config.extent)
        self._whole_sights += extent.seen_whole(seen.size, seen.whole, self._config.extent)
        self._resize(longer)
        self._follow(seen.corner_sign)
        self._belief.see(seen, self.seen_size)
        self._belief.go(seen, self.footprint)
        self._face_forward()

    def absorb(self, low: Floats, high: Floats) -> None:
        """Take over all within a box that holds this one.

        Its low and high corner (2,) are given from the middle of what was seen of this track, along and across [m].
        """
        corner = np.where(self.corner_sign > 0, high, low)
        own = 0.5 * self.corner_sign * self.seen_size
        self._shift(rotate(corner - own, self.heading))
        self._resize(high - low)

    def settle(self) -> None:
        """Decide the status after a frame's updates."""
        life = self._config.life
        if self.status is Status.DEAD:
            return
        if self.seen:
            if self._belief.holds(self.hits, self.seen_size):
                self.status = Status.CONFIRMED
            elif not extent.car_sized(self.seen_size, self._config.extent):
                self.status = Status.TENTATIVE
            if extent.too_large(self.seen_size, self._config.extent):
                self.status = Status.DEAD
        elif self.status is not Status.TENTATIVE:
            lost = np.trace(self.covariance) > 2 * life.coast_std_max_m**2
            if lost or self.unseen_s > life.gap_s:
                self.status = Status.DEAD if lost else Status.COASTING

    @property
    def long(self) -> bool:
        """Whether it is longer than a car."""
        return extent.long(self.seen_size, self._config.extent)

    @property
    def footprint(self) -> Footprint:
        """Where it is, as far as it has been seen, from the tracked corner on."""
        middle = self.position - rotate(0.5 * self.corner_sign * self.seen_size, self.heading)
        return Footprint(middle, self.heading, self.seen_size)

    def _resize(self, seen_size: Floats) -> None:
        """Take (2,) for what has been seen of length and width [m], and complete it to the vehicle's size."""
        self.seen_size = seen_size
        usual = extent.classify(seen_size, self._whole_sights, self._oriented_hits, self._config.extent)
        self.size = extent.complete(seen_size, self._whole_sights, usual, self._config.extent)
        """(2,) length and width [m], unseen sides from priors."""

    @property
    def _end_variance(self) -> Floats:
        """(2,) of where the vehicle ends, along and across, when the other end is known [m^2]."""
        corner, unseen = self._config.corner, self.size - self.known_size
        return np.square(np.maximum(corner.known_std_m, corner.unseen_share * unseen))

    def _loosen(self, seen: TrackObservation) -> None:
        """What an end was off by, and is no more, the filters may now learn at once: it is no motion."""
        past = self._offset_variance - variance_along(seen.covariance, self.heading)
        learnt = spread(np.where(seen.exact, np.maximum(past, 0.0), 0.0), self.heading)
        self.bank.loosen(learnt)
        self.alone.loosen(learnt)

    def _follow(self, corner_sign: Ints) -> None:
        """Move the state by the known side length when another corner is measured, so that it does not jump."""
        changes = corner_sign != self.corner_sign
        if changes.any():
            self._shift(rotate(0.5 * (corner_sign - self.corner_sign) * self.size, self.heading))
            self._offset_variance = self._offset_variance + np.where(changes, self._end_variance, 0.0)
            self.corner_sign = corner_sign

    def _shift(self, offset: Floats) -> None:
        """Follow another point, (2,) [m] away from the tracked one."""
        self.bank.shift(offset)
        self.alone.shift(offset)
        self._turn_from = self._turn_from + offset

    def _update_heading(self, heading: float, variance: float) -> None:
        """Correct the heading unless it is an outlier; one that insists is believed."""
        life, off = self._config.life, heading - self.heading
        innovation_std = np.sqrt(self._heading.covariance[0, 0, 0] + variance)
        if abs(off) > life.heading_gate_sigma * innovation_std:
            self._heading_rejections += 1
            if self._heading_rejections <= life.heading_rejections_max:
                return
            self._heading.mean[0] = heading, 0.0
            off = 0.0
        self._heading_rejections = 0
        self._heading.correct(np.array([[off]]), np.array([[variance]]))
        self._heading.mean[0, 0] = wrap(self.heading)

    def _face_forward(self) -> None:
        """Turn the heading by quarters once motion, or else the size, has contradicted it for long enough.

        Once motion has told where the vehicle faces, its size has no more say, unless it is wider than vehicles are.
        """
        config, course = self._config.orientation, self.course
        if course is None:
            too_wide = self.seen_size[1] > config.width_max_m
            quarters = 0
            if too_wide or not self._oriented:
                quarters = orientation.by_size(
                    self.heading, self.seen_size, self._whole_sights > 0, self._forward, config
                )
            self._votes = self._votes + 1 if quarters else 0
            self._turn_from = self.position
            if self._votes >= config.votes:
                self._turn(quarters)
            return
        quarters = orientation.by_course(self.heading, course)
        if quarters == 0:
            self._turn_from, self._oriented = self.position, True
        elif np.hypot(*(self.position - self._turn_from)) > orientation.way_needed(quarters, self.seen_size, config):
            self._turn(quarters)
            self._oriented = True

    def _turn(self, quarters: int) -> None:
        """Name the same box by a heading turned by `quarters`."""
        self._heading.mean[0, 0] = wrap(self.heading + quarters * QUARTER)
        self.corner_sign = orientation.turn_sign(self.corner_sign, quarters)
        self._offset_variance = orientation.turn_size(self._offset_variance, quarters)
        self._whole_sights = self._whole_sights[:: -1 if quarters % 2 else 1].copy()
        self._resize(orientation.turn_size(self.seen_size, quarters))
        self._votes, self._turn_from = 0, self.position
