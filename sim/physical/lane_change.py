"""Lane changes that a simulator makes in one step, spread over the seconds that they take on the road."""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from sim.world import Floats

Bools = npt.NDArray[np.bool_]

JUMP_SPEED = 7.0
"""[m/s] sideways, from which a step across the lane is a jump: no steering does that, and SUMO's own modes with a
lateral resolution or a duration of lane changes stay below half of it."""
JUMP_LONGEST = 6.0
"""[m] sideways; what moves farther in one step did not change lanes."""
CORNER = 0.4
"""A corner of a lane's polyline turns the way ahead sideways, too: up to this share of it is no jump."""
LEAST_STEP = 0.005
"""[m] A shorter step does not tell a course."""
SLOW = 4.0
"""[m/s] Slower bodies take longer, as they cover the same way along the road; who stands, waits."""


def courses(before: Floats, step: Floats, dt: float) -> tuple[Floats, Bools, Floats]:
    """Tell where bodies are heading, and who jumped to the next lane.

    SUMO's own angle will not do: after a jump it is that of a body askew across both lanes.

    Parameters
    ----------
    before
        (N,) courses in the last frame [rad].
    step
        (N, 2) from the last position to this one [m].
    dt
        Time between the two [s].

    Returns
    -------
    course
        (N,) of the step [rad]; the last one for those who jumped or hardly moved.
    jumped
        (N,) who jumped.
    offset
        (J,) how far these did, to the left [m].
    """
    cos, sin = np.cos(before), np.sin(before)
    across = step[:, 1] * cos - step[:, 0] * sin
    along = step[:, 0] * cos + step[:, 1] * sin
    jumped = (np.abs(across) > JUMP_SPEED * dt + CORNER * np.abs(along)) & (np.abs(across) <= JUMP_LONGEST)
    moved = ~jumped & (np.hypot(*step.T) > LEAST_STEP)
    return np.where(moved, np.arctan2(step[:, 1], step[:, 0]), before), jumped, across[jumped]


@dataclass(frozen=True, slots=True)
class LaneChange:
    """One jump that is being spread."""

    id: int
    """Of the body."""
    frame: int
    """Of the jump."""
    offset: float
    """[m] to the left."""
    progress: float = 0.0
    """0 before it to 1 after it."""

    def onward(self, speed: float, fraction: float) -> "LaneChange":
        """Go on for a step that is `fraction` of a whole change, at a speed [m/s]."""
        return replace(self, progress=min(self.progress + fraction * min(speed / SLOW, 1.0), 1.0))

    def shift(self, frame: int) -> float:
        """Return how far [m] to the left of the simulator's position the body belongs at a frame.

        The way across is the quintic of least jerk, 10 s^3 - 15 s^4 + 6 s^5.
        """
        s = self.progress
        done = s**3 * (10 - 15 * s + 6 * s**2)
        return self.offset * (done if frame < self.frame else done - 1.0)
