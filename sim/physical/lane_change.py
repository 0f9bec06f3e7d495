"""Instant lane changes of a simulator, spread over a realistic duration."""

from dataclasses import dataclass, replace

from luxloop.sim.physical.limits import SLOW_CHANGE


def minimum_jerk(s: float) -> float:
    """Return the minimum-jerk quintic 10 s^3 - 15 s^4 + 6 s^5, from 0 at s = 0 to 1 at s = 1."""
    return s * s * s * (10 - 15 * s + 6 * s * s)


@dataclass(frozen=True, slots=True)
class SpreadLaneChange:
    """State of one lane change in progress."""

    body: int
    """Row of the body."""
    frame: int
    """Frame of the jump."""
    offset: float
    """[m] Lateral jump, positive to the left."""
    progress: float = 0.0
    """From 0 before the lane change to 1 after it."""

    def advanced(self, speed: float, fraction: float) -> "SpreadLaneChange":
        """Return the state after a step at a speed [m/s]; the step is `fraction` of a whole lane change."""
        return replace(self, progress=min(self.progress + fraction * min(speed / SLOW_CHANGE, 1.0), 1.0))

    def shift(self, frame: int) -> float:
        """Return the lateral shift [m], positive to the left, of the simulator's position at a frame.

        The lateral profile is `minimum_jerk`.
        """
        done = minimum_jerk(self.progress)
        return self.offset * (done if frame < self.frame else done - 1.0)
