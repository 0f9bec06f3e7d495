"""One tracked vehicle: its filters, its corner, its size and its life."""

from dataclasses import dataclass

import numpy as np

from tracker import extent, mma, orientation
from tracker.extent import ExtentConfig
from tracker.filters import Bank, FilterConfig, Motion
from tracker.footprint import Footprint
from tracker.geometry import QUARTER, rotate, wrap
from tracker.mma import MmaConfig
from tracker.orientation import OrientationConfig
from tracker.records import MODELS, Bools, Floats, Ints, Status

STATIONARY = MODELS.index("stationary")
TURNING = MODELS.index("ca")


@dataclass(frozen=True, slots=True)
class LifeConfig:
    """When a track is believed and when it is given up."""

    confirm_hits: int = 4
    """Observations before a track is confirmed."""
    tentative_coast_s: float = 0.2
    """A tentative track dies when not seen for longer than this [s]."""
    gap_s: float = 0.25
    """A confirmed track stays so through gaps this short [s]; longer ones make it coast."""
    coast_s: float = 3.0
    """A confirmed track waits this long for re-association [s]."""
    coast_std_max_m: float = 3.0
    """It is given up earlier when its position is no better known than this [m]."""
    heading_gate_sigma: float = 4.0
    """A measured heading farther off than this is not believed ..."""
    heading_rejections_max: int = 8
    """... unless it comes this often in a row."""


@dataclass(frozen=True, slots=True)
class TrackConfig:
    """All that one track needs to know."""

    filters: FilterConfig
    mma: MmaConfig
    extent: ExtentConfig
    orientation: OrientationConfig
    life: LifeConfig


class Track:
    """A vehicle followed by one of its corners, in the odometry frame."""

    def __init__(
        self,
        track_id: int,
        position: Floats,
        heading: float,
        size: Floats,
        corner_sign: Ints,
        covariance: Floats,
        sight: bool,
        forward: float,
        config: TrackConfig,
    ) -> None:
        """Start on one observation; `sight` tells whether it showed sides of a vehicle."""
        self.id = track_id
        self.status = Status.TENTATIVE
        self.bank = Bank(position, heading, covariance, config.filters)
        self.model_probability = mma.initial_probability()
        self.model = STATIONARY
        """The selected model: the highest score of (12)."""
        self.corner_sign = corner_sign
        self.hits = 1
        self.unseen_s = 0.0
        self._config = config
        self._forward = forward
        self._oriented = False
        self._oriented_hits = 0
        self._voted = 0
        self._votes = 0
        self._heading_rejections = 0
        self._whole_sights = np.zeros(2, dtype=np.int64)
        """(2,) how often length and width were seen from end to end."""
        self._resize(size)
        self._birthplace = self.footprint
        self._left = False
        self._sights = [int(sight), 0]
        """How often sides of a vehicle were seen, before and after more than a car's length was seen."""

    @property
    def heading(self) -> float:
        """Heading [rad]."""
        return float(self.bank.heading.x[0])

    @property
    def known_size(self) -> Floats:
        """(2,) how much of length and width is known to be there, from the tracked corner on [m]."""
        return extent.known(self.seen_size, self.size, self._config.extent)

    @property
    def covariance(self) -> Floats:
        """(2, 2) of the tracked corner by the selected model [m^2]."""
        return np.asarray(self.bank.models[self.model].P[:2, :2])

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
        """(2,) tracked corner by the selected model [m]."""
        return np.asarray(self.bank.models[self.model].x[:2])

    @property
    def velocity(self) -> Floats:
        """(2,) by the selected model [m/s]."""
        return np.asarray(self.bank.velocity[self.model])

    @property
    def course(self) -> float | None:
        """Direction of motion by the selected model [rad], None for a vehicle that may be standing."""
        kf = self.bank.models[self.model]
        if self.model == STATIONARY:
            return None
        return orientation.course(kf.x[2:4], kf.P[2:4, 2:4], self._config.orientation)

    def predict(self, step: Motion) -> None:
        """Move on by one time step; the track counts as unseen until it is updated.

        Only the constant acceleration model lets a vehicle turn: the others set its yaw rate to zero.
        """
        if self.model != TURNING:
            self.bank.heading.x[1] = 0.0
        self.bank.predict(step)
        self.unseen_s += step.dt

    def update(
        self,
        misfit: Floats,
        heading: float,
        size: Floats,
        whole: Bools,
        flat: bool,
        covariance: Floats,
        heading_variance: float,
        corner_sign: Ints,
    ) -> None:
        """Take over one observation.

        Parameters
        ----------
        misfit, covariance
            (M, 2) from each model's prediction of the tracked corner to the observed one [m], and (2, 2) [m^2].
        heading, heading_variance
            Near the track's own [rad], [rad^2].
        size
            (2,) seen extent along and across the heading [m].
        whole
            (2,) whether that is cut off at neither end.
        flat
            Whether it misses a side that a vehicle would show.
        corner_sign
            (2,) the corner to track from now on.
        """
        evidence = self.bank.log_likelihood(misfit, covariance)
        self.model_probability = mma.update(self.model_probability, evidence, self._config.mma)
        self.model = int(np.argmax(self.model_probability))
        self.bank.update(misfit, covariance)
        self._update_heading(heading, heading_variance)
        self.hits += 1
        self._oriented_hits += self._oriented
        self.unseen_s = 0.0
        longer = extent.remember(self.seen_size, size, whole, self._whole_sights, self._config.extent)
        self._whole_sights += extent.seen_whole(size, whole, self._config.extent)
        self._resize(longer)
        self._follow(corner_sign)
        largest = np.maximum(self.seen_size, size)
        self._sights[self.long] += extent.is_vehicle(size, whole, largest, self._config.extent) - flat
        # A bare face that is cut off slides along itself as what hides it moves; across itself it is where it is.
        fixed = whole | (size[::-1] > self._config.extent.face_min_m)
        self._left |= bool(np.any(fixed & self.footprint.clear_of(self._birthplace)))
        self._face_forward()

    def absorb(self, low: Floats, high: Floats) -> None:
        """Grow to a box that holds what was seen of this track.

        Its low and high corner (2,) are given from the middle of that, along and across the heading [m].
        """
        corner = np.where(self.corner_sign > 0, high, low)
        own = 0.5 * self.corner_sign * self.seen_size
        self.bank.shift(rotate(corner - own, self.heading))
        self._resize(high - low)

    def settle(self) -> None:
        """Decide the status after a frame's updates."""
        life = self._config.life
        if self.seen:
            if self._believed:
                self.status = Status.CONFIRMED
            elif self.long:
                self.status = Status.TENTATIVE
            if extent.too_large(self.seen_size, self._config.extent):
                self.status = Status.DEAD
        elif self.status is Status.TENTATIVE:
            if self.unseen_s > life.tentative_coast_s:
                self.status = Status.DEAD
        else:
            lost = self.unseen_s > life.coast_s or np.trace(self.covariance) > 2 * life.coast_std_max_m**2
            if lost or self.unseen_s > life.gap_s:
                self.status = Status.DEAD if lost else Status.COASTING

    @property
    def _believed(self) -> bool:
        """Whether this is a vehicle: it left its place, or sides as long as a vehicle's were seen from end to end."""
        least = self._config.life.confirm_hits
        return self.hits >= least and (self._left or self._sights[self.long] >= least)

    @property
    def long(self) -> int:
        """Whether it is longer than a car."""
        return int(self.seen_size.max() > self._config.extent.large_length_min_m)

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

    def _follow(self, corner_sign: Ints) -> None:
        """Move the state by the known side length when another corner is measured, so that it does not jump."""
        side = 0.5 * (corner_sign - self.corner_sign) * self.size
        if side.any():
            self.bank.shift(rotate(side, self.heading))
            self.corner_sign = corner_sign

    def _update_heading(self, heading: float, variance: float) -> None:
        """Correct the heading unless it is an outlier; one that insists is believed."""
        life, kf = self._config.life, self.bank.heading
        innovation_std = np.sqrt(kf.P[0, 0] + variance)
        if abs(heading - kf.x[0]) > life.heading_gate_sigma * innovation_std:
            self._heading_rejections += 1
            if self._heading_rejections <= life.heading_rejections_max:
                return
            kf.x[:] = heading, 0.0
        self._heading_rejections = 0
        kf.update(np.array([heading]), R=variance)
        kf.x[0] = wrap(kf.x[0])

    def _face_forward(self) -> None:
        """Turn the heading by quarters once motion or size have contradicted it for long enough.

        Once motion has told where the vehicle faces, its size has no more say while it stands.
        """
        config, course = self._config.orientation, self.course
        if course is None and self._oriented:
            return
        whole = self._whole_sights > 0
        quarters = orientation.contradiction(self.heading, course, self.seen_size, whole, self._forward, config)
        self._votes = self._votes + 1 if quarters == self._voted else 1
        self._voted = quarters
        if self._votes < (config.votes if self._oriented else config.first_votes):
            return
        self._oriented |= course is not None
        if quarters:
            self.bank.heading.x[0] = wrap(self.heading + quarters * QUARTER)
            self.corner_sign = orientation.turn_sign(self.corner_sign, quarters)
            self._whole_sights = self._whole_sights[:: -1 if quarters % 2 else 1].copy()
            self._resize(orientation.turn_size(self.seen_size, quarters))
            self._votes = 0
