"""Lane changes that a simulator makes in one step, spread over the seconds that they take on the road."""

from dataclasses import dataclass, replace

from sim.physical.limits import SLOW_CHANGE


@dataclass(frozen=True, slots=True)
class SpreadLaneChange:
    """One jump that is being spread."""

    body: int
    """Its row."""
    frame: int
    """Of the jump."""
    offset: float
    """[m] to the left."""
    progress: float = 0.0
    """0 before it to 1 after it."""

    def onward(self, speed: float, fraction: float) -> "SpreadLaneChange":
        """Go on for a step that is `fraction` of a whole change, at a speed [m/s]."""
        return replace(self, progress=min(self.progress + fraction * min(speed / SLOW_CHANGE, 1.0), 1.0))

    def shift(self, frame: int) -> float:
        """Return how far [m] to the left of the simulator's position the body belongs at a frame.

        The way across is the quintic of least jerk, 10 s^3 - 15 s^4 + 6 s^5.
        """
        s = self.progress
        done = s**3 * (10 - 15 * s + 6 * s**2)
        return self.offset * (done if frame < self.frame else done - 1.0)
