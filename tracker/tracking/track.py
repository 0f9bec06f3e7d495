"""Tracked vehicle: tracked corner, heading, size and status."""

import cmath

import numpy as np

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.geometry import rotate_one
from luxloop.tracker.records import Status
from luxloop.tracker.tracking import orientation, vehicle_size
from luxloop.tracker.tracking.confirmation import Confirmation, Footprint
from luxloop.tracker.tracking.corner_estimator import CornerEstimator
from luxloop.tracker.tracking.existence import existence, same_vehicle
from luxloop.tracker.tracking.filter_bank import FilterBank
from luxloop.tracker.tracking.filters import Motion
from luxloop.tracker.tracking.heading import HeadingEstimator
from luxloop.tracker.tracking.orientation import TURN_LOG_ODDS, Course
from luxloop.tracker.tracking.track_config import TrackConfig
from luxloop.tracker.tracking.track_observation import TrackObservation
from luxloop.tracker.tracking.traffic_flow import TrafficFlow
from luxloop.tracker.tracking.turning import (
    Turn,
    axle_to_corner,
    motion_direction,
    turning_among,
    with_turn,
    with_turning_acceleration,
)
from luxloop.tracker.tracking.vehicle_size import SizeEstimator
from luxloop.tracker.vehicle_classes import WIDE_M


class Track:
    """A vehicle tracked by one of its corners, in the odometry frame.

    Parameters
    ----------
    track_id
        Id that no other track has.
    position
        (2,) corner to track [m].
    first
        First observation.
    bank
        Filter bank at `position`.
    """

    def __init__(
        self,
        track_id: int,
        position: Floats,
        first: TrackObservation,
        config: TrackConfig,
        bank: FilterBank,
    ) -> None:
        self.id = track_id
        self.status = Status.TENTATIVE
        self.hits = 1
        self.unseen_s = 0.0
        self.age_s = 0.0
        self._config = config
        self._heading = HeadingEstimator(first, position, config)
        self._heading.observe_sides(first.size, first.whole)
        self._size = SizeEstimator(first.size, first.whole, config.extent)
        self.corner = CornerEstimator(position, first, self.heading, self._unseen_size, config, bank)
        self._confirmation = Confirmation(config.confirmation, self.footprint)
        self._confirmation.count(first)
        self._axis_log_odds = -np.inf
        """Log-odds that the length is along the heading: a box turned by a quarter would cover another place."""

    @property
    def heading(self) -> float:
        """Heading [rad]."""
        return self._heading.heading

    @property
    def yaw_state(self) -> tuple[Floats, Floats]:
        """Heading and yaw rate (2,), and their covariance (2, 2)."""
        return self._heading.state

    @property
    def heading_variance(self) -> float:
        """[rad^2]."""
        return self._heading.variance

    @property
    def size(self) -> Floats:
        """(2,) length and width, unseen parts from priors [m]."""
        return self._size.size

    @property
    def seen_size(self) -> Floats:
        """(2,) seen length and width [m]."""
        return self._size.seen

    @property
    def whole_views(self) -> Ints:
        """(2,) numbers of views of length and width from end to end."""
        return self._size.whole_views

    @property
    def known_size(self) -> Floats:
        """(2,) part of length and width that is known to exist, from the tracked corner on [m]."""
        return self._size.known

    @property
    def size_std(self) -> Floats:
        """(2,) standard deviations of length and width [m]."""
        return self._size.std

    @property
    def offset_covariance(self) -> Floats:
        """(2, 2) covariance of the time-correlated error, odometry frame [m^2]."""
        return self.corner.offset_covariance(self.heading)

    @property
    def covariance(self) -> Floats:
        """(2, 2) covariance of the tracked corner [m^2]."""
        return self.corner.covariance(self.heading)

    @property
    def turn(self) -> Turn:
        """Known inputs of turning models."""
        state, variance = self._heading.state
        (heading, yaw_rate), velocity = state.tolist(), complex(*self.corner.velocity.tolist())
        direction = motion_direction(velocity, heading, yaw_rate, self._axle_to_corner)
        return Turn(yaw_rate, variance[1, 1], variance[0, 0], velocity, direction)

    @property
    def seen(self) -> bool:
        """True if the track was updated in this frame."""
        return self.unseen_s == 0.0

    @property
    def confirmed_now(self) -> bool:
        """True if the track is confirmed and was updated in this frame."""
        return self.status is Status.CONFIRMED and self.seen

    @property
    def shows_direction(self) -> bool:
        """True if the direction of the vehicle is known: confirmed by motion, or by the length of its side."""
        known = self._heading.oriented or self.seen_size[0] > WIDE_M
        return known and self.status is Status.CONFIRMED

    @property
    def long(self) -> bool:
        """True if the vehicle is longer than a car."""
        return vehicle_size.long(self.seen_size)

    @property
    def footprint(self) -> Footprint:
        """Area that was seen to be covered by the vehicle, starting at the tracked corner."""
        return self._footprint(self.corner.position)

    def predict(self, motion: Motion) -> None:
        """Move on by one time step; terminate the track if it was not seen for too long."""
        self.corner.predict(*self.advance(motion))

    def advance(self, motion: Motion) -> tuple[Motion, Motion]:
        """Move all but the corner on by one time step; return the motions of its independent filters and of its bank.

        Of the paper's models, only constant acceleration lets a vehicle turn: the others set its yaw rate to zero. With
        a turning model in the bank only the stationary one does.
        """
        turns = self.corner.model_name == "ca"
        if turning_among(motion.names):
            turns = self.corner.model_name != "stationary"
            motion = with_turn(motion, self.turn)
        self._heading.predict(motion, self.corner.speed, turning=turns)
        of_bank = self._bank_motion(motion)
        self.unseen_s += motion.dt
        self.age_s += motion.dt
        self._wait(missed_s=self.unseen_s - motion.dt)
        return motion, of_bank

    def update(self, seen: TrackObservation) -> None:
        """Update all estimates by one observation."""
        seen = self.admit(seen)
        self.corner.observe(seen, self.heading)
        self.follow(seen)

    def admit(self, seen: TrackObservation) -> TrackObservation:
        """Return an observation for the corner; the second one of a track shows its speed.

        After a track has coasted, the observation may be of another object.
        """
        if self.status is Status.COASTING and not self.seen:
            density = self.corner.density(seen, self.heading)
            same = same_vehicle(self.unseen_s, density, self._config.existence)
            self._confirmation.reacquire(same)
        return self.corner.start(seen, self.unseen_s) if self.hits == 1 else seen

    def follow(self, seen: TrackObservation) -> None:
        """Update all but the corner, which was updated before, by one observation."""
        self._heading.observe(seen.heading, seen.heading_variance)
        self._heading.observe_sides(seen.size, seen.whole)
        self.hits += 1
        self.unseen_s = 0.0
        self._size.observe(seen.size, seen.whole)
        if seen.corner_sign.tolist() != self.corner.sign.tolist():
            offset = self.corner.change_corner(
                seen.corner_sign, self.size, self._unseen_size, self.heading, self._heading.yaw_rate[0]
            )
            self._heading.shift(offset)
        self._confirmation.count(seen)
        course, position = self._course, self.corner.position
        if not self._confirmation.left:
            self._confirmation.check_motion(seen, self._footprint(position), position, moving=course is not None)
        self._turn(self._heading.turns_to_front(course, position, self.seen_size))

    def orient(self, flow: TrafficFlow) -> None:
        """Turn a stationary vehicle to its likeliest direction; motion has precedence, unless it is too wide."""
        moved = self._heading.oriented and self.seen_size.item(1) <= WIDE_M
        if moved or self._course is not None:
            self._axis_log_odds = np.inf
            return
        flow, place = flow.without(self.id), self.footprint.center
        turns = orientation.likeliest_turns(self._heading.length_log_odds, place, self.heading, flow, TURN_LOG_ODDS)
        self._turn(turns)
        self._axis_log_odds = self._heading.length_log_odds + flow.axis_log_odds(place, self.heading)

    def absorb(self, low: Floats, high: Floats) -> None:
        """Extend the track to a box that contains it.

        `low` and `high` are the corners (2,) of that box relative to the centre of the seen part, along and across the
        heading [m].
        """
        own = 0.5 * self.corner.sign * self.seen_size
        offset = rotate_one(np.where(self.corner.sign > 0, high, low) - own, self.heading)
        self.corner.shift(offset, self._heading.yaw_rate[0])
        self._heading.shift(offset)
        self._size.extend(high - low)

    def settle(self) -> None:
        """Update the status after an observation: confirm or refute the track, or terminate one that is too large."""
        if self.status is Status.DEAD or not self.seen:
            return
        sure = self._axis_log_odds >= TURN_LOG_ODDS
        if sure and self._confirmation.confirms(self.hits):
            self.status = Status.CONFIRMED
        elif self._confirmation.refutes:
            self.status = Status.TENTATIVE
        if vehicle_size.too_large(self.seen_size):
            self.status = Status.DEAD

    def _wait(self, missed_s: float) -> None:
        """Let a track coast that was not seen for a while, `missed_s` before this scan; terminate it in the end."""
        confirmation, memory = self._config.confirmation, self._config.existence
        if self.status is Status.TENTATIVE:
            if missed_s > confirmation.tentative_coast_s:
                self.status = Status.DEAD
        elif existence(self.unseen_s, 1.0, memory) < memory.existence_min:
            self.status = Status.DEAD
        elif self.unseen_s > confirmation.gap_s:
            self.status = Status.COASTING

    def _bank_motion(self, motion: Motion) -> Motion:
        """Return the motion of the bank, in which `ca` turns with the vehicle; independent filters go straight on."""
        filters = self._config.filters
        if filters.heading == "paper" or self.corner.stationary:
            return motion
        velocity = complex(*self.corner.velocity.tolist())
        return with_turning_acceleration(motion, *self._heading.yaw_rate, velocity, filters.jerk_std_mps3)

    @property
    def _unseen_size(self) -> Floats:
        """(2,) uncertain part of length and width [m]: two standard deviations."""
        return 2.0 * self._size.std

    @property
    def _course(self) -> Course | None:
        """Direction of motion, None for a vehicle that may be stationary."""
        if self.corner.stationary:
            return None
        return self.corner.course(-self._axle_to_corner, *self._heading.yaw_rate)

    @property
    def _axle_to_corner(self) -> complex:
        """Vector from the middle of the rear axle to the tracked corner, odometry frame [m]."""
        return axle_to_corner(self.corner.sign, self.size) * cmath.rect(1.0, self.heading)

    def _footprint(self, corner: Floats) -> Footprint:
        """Return the footprint of a track whose tracked corner is at (2,) [m]."""
        (x, y), (front, left), (length, width) = corner.tolist(), self.corner.sign.tolist(), self.seen_size.tolist()
        middle = complex(x, y) - complex(0.5 * front * length, 0.5 * left * width) * cmath.rect(1.0, self.heading)
        return Footprint(np.array([middle.real, middle.imag]), self.heading, self.seen_size)

    def _turn(self, quarters: int) -> None:
        """Describe the same box by a heading turned by `quarters`."""
        if quarters == 0:
            return
        self._heading.turn(quarters, self.corner.position)
        self._confirmation.turn()
        self.corner.turn(quarters)
        self._size.turn(quarters)
