"""Evidence of several views of one object, whose errors are correlated."""

import cmath
import math
from dataclasses import dataclass

from luxloop.tracker.arrays import Floats
from luxloop.tracker.bounds import require_within
from luxloop.tracker.tracking.track_observation import TrackObservation
from luxloop.tracker.vehicle_classes import FACE_MIN_M, TRUNCATED_PROBABILITY, vehicle_log_odds


def correlated_sum(total: float, views: int, correlation: float) -> float:
    """Return the evidence of a `total` of log-odds over views of one object, whose errors are correlated.

    The evidence of n equal views with correlation r is that of n / (1 + (n - 1) r).
    """
    return total / (1.0 + correlation * max(views - 1, 0))


LEFT_MARGIN_M = 1.5
"""Clearance of a vehicle that left a place [m]: the position of a small piece of wall along the wall is this
uncertain."""


@dataclass(frozen=True, slots=True, eq=False)
class Footprint:
    """Rectangle covered by the visible part of a track, odometry frame."""

    center: Floats
    """(2,) centre of the visible part [m]."""
    heading: float
    """[rad]."""
    size: Floats
    """(2,) extent of the visible part along and across the heading [m]."""

    def clear_of(self, other: "Footprint") -> tuple[bool, bool]:
        """Flags of the axes, along and across this heading, on which the two footprints do not overlap.

        The speed of a filter does not show that an object moved: while more and more of a wall comes into view, its
        centre moves like that of a vehicle, but it always overlaps its first footprint.
        """
        (length, width), (other_length, other_width) = self.size.tolist(), other.size.tolist()
        away = complex(*(self.center - other.center).tolist()) * cmath.rect(1.0, -self.heading)
        turn = cmath.rect(1.0, other.heading - self.heading)
        cos, sin = abs(turn.real), abs(turn.imag)
        along = 0.5 * (length + cos * other_length + sin * other_width)
        across = 0.5 * (width + sin * other_length + cos * other_width)
        return abs(away.real) > along + LEFT_MARGIN_M, abs(away.imag) > across + LEFT_MARGIN_M


VIEW_CORRELATION = 0.2
"""Correlation of the views of one object: the evidence of many equal views is that of five."""

VIEW_LOG_ODDS_MAX = 2.0
"""Maximum evidence of one view against a vehicle, log-odds."""

VEHICLE_LOG_ODDS_MAX = 3.0
"""Maximum evidence of one view for a vehicle, log-odds."""

FLAT_LOG_ODDS = 2.0
"""Evidence against a vehicle of a side that a vehicle would show, but is missing, log-odds."""

MOTION_LOG_ODDS = 20.0
"""Evidence of an object that left its first place, log-odds: background does not move."""

MOVED_VIEWS_MIN = 3
"""Minimum number of successive observations of an end away from its first place that are motion."""


@dataclass(frozen=True, slots=True)
class ConfirmationConfig:
    """Track confirmation, coasting and termination."""

    vehicle_prior: float = 0.5
    """Probability that a new track is a vehicle: about half of the objects of vehicle size beside roads are."""
    confirm_probability: float = 0.9
    """Probability of a vehicle at which a track is confirmed; at the opposite one it becomes tentative again."""
    confirm_hits: int = 3
    """Minimum number of observations for confirmation."""
    tentative_coast_s: float = 0.15
    """A tentative track is terminated if it was not seen for longer than this before the last scan [s]."""
    gap_s: float = 0.25
    """A confirmed track stays confirmed through gaps up to this length [s] and coasts after it."""

    def __post_init__(self) -> None:
        require_within(self, 0.5, 1.0 - 1e-9, "confirm_probability")
        require_within(self, 1e-9, 1.0 - 1e-9, "vehicle_prior")


class Confirmation:
    """Log-odds that one track is a vehicle, from the prior at its birth."""

    def __init__(self, config: ConfirmationConfig, birthplace: Footprint) -> None:
        self._config = config
        self._least = math.log(config.confirm_probability / (1.0 - config.confirm_probability))
        self._prior = math.log(config.vehicle_prior / (1.0 - config.vehicle_prior))
        self._birthplace: Footprint | None = birthplace
        """Place to leave; None until the next observation."""
        self._ends: dict[tuple[int, int], complex] = {}
        """Tracked corner x + iy [m] when the end of an axis and a sign was first visible."""
        self._moved_views = 0
        """Successive observations in which a visible end was away from its first place."""
        self.left = False
        """True once the object has left its first place, or moved on after it was hidden."""
        self._moved_before_hidden = False
        self._moving_views = 0
        """Successive observations with a speed, since the vehicle was hidden."""
        self._shape_sum, self._views = 0.0, 0

    @property
    def log_odds(self) -> float:
        """Log-odds of a vehicle."""
        shape = correlated_sum(self._shape_sum, self._views, VIEW_CORRELATION)
        return self._prior + shape + self.left * MOTION_LOG_ODDS

    def confirms(self, hits: int) -> bool:
        """Return True if the track is a vehicle, after `hits` observations."""
        return hits >= self._config.confirm_hits and self.log_odds >= self._least

    @property
    def refutes(self) -> bool:
        """True if the track is as surely not a vehicle as confirmation needs it to be one."""
        return self.log_odds <= -self._least

    def count(self, seen: TrackObservation) -> None:
        """Count a view as evidence for or against a vehicle."""
        shape = vehicle_log_odds(seen.size, seen.whole, TRUNCATED_PROBABILITY) - FLAT_LOG_ODDS * seen.flat
        self._shape_sum += min(max(shape, -VIEW_LOG_ODDS_MAX), VEHICLE_LOG_ODDS_MAX)
        self._views += 1

    def reacquire(self, same: float) -> None:
        """Begin again with an object that is, with a probability, the vehicle that was hidden.

        Another object is a vehicle with the prior probability of new tracks. Motion counts again as soon as the object
        moves, as the vehicle did.
        """
        vehicle = same / (1.0 + math.exp(-self.log_odds)) + (1.0 - same) * self._config.vehicle_prior
        vehicle = min(vehicle, CERTAIN)
        self._prior = math.log(vehicle / (1.0 - vehicle))
        self._moved_before_hidden |= self.left
        self.left, self._moved_views, self._moving_views, self._birthplace = False, 0, 0, None
        self._shape_sum, self._views = 0.0, 0
        self._ends.clear()

    def check_motion(self, seen: TrackObservation, footprint: Footprint, corner: Floats, moving: bool) -> None:
        """Check if an object leaves its first place, or is `moving` on as before it was hidden.

        Its tracked corner is at (2,) [m]. A single truncated face seems to slide along itself when its occluder moves,
        so only its motion across counts.
        """
        self._birthplace = self._birthplace or footprint
        length, width = seen.size.tolist()
        faces = width > FACE_MIN_M, length > FACE_MIN_M
        sides = zip(seen.whole.tolist(), faces, footprint.clear_of(self._birthplace), strict=True)
        self.left |= any((whole or face) and clear for whole, face, clear in sides)
        moves, place, back = False, complex(*corner.tolist()), cmath.rect(1.0, -footprint.heading)
        for axis, (exact, face, sign) in enumerate(
            zip(seen.exact.tolist(), faces, seen.corner_sign.tolist(), strict=True)
        ):
            if exact and face:
                shift = (place - self._ends.setdefault((axis, sign), place)) * back
                moves |= abs(shift.imag if axis else shift.real) > LEFT_MARGIN_M
        self._moved_views = self._moved_views + 1 if moves else 0
        self._moving_views = self._moving_views + 1 if moving else 0
        self.left |= self._moved_views >= MOVED_VIEWS_MIN
        self.left |= self._moved_before_hidden and self._moving_views >= MOVED_VIEWS_MIN

    def turn(self) -> None:
        """Forget the ends of the object, whose names change when its heading is turned by quarters."""
        self._ends.clear()


CERTAIN = 1.0 - 1e-9
"""Largest probability of a vehicle, for finite log-odds."""
