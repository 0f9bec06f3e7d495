"""Log of the truth events of a run, and the bodies that are not graded because of them."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Bools, Floats
from luxloop.scenarios.grading.truth_events.bodies import EGO_ROW, Bodies
from luxloop.scenarios.grading.truth_events.body_motion import MotionHistory, is_jump
from luxloop.scenarios.grading.truth_events.body_overlaps import Overlaps, overlaps
from luxloop.scenarios.grading.truth_events.episodes import Episodes
from luxloop.scenarios.grading.truth_events.event_limits import FRINGE_M
from luxloop.scenarios.grading.truth_events.presence import Presence
from luxloop.scenarios.grading.truth_events.truth_event import TruthEvent, event_table
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.world import Collision, WorldFrame


@dataclass(frozen=True, slots=True, eq=False)
class FrameEvents:
    """Events of one frame with A actors."""

    began: list[TruthEvent]
    """Events that begin in this frame."""
    masked: Bools
    """(A,) actors that overlap another body, or that appeared or moved in view shortly before: they are not graded."""
    ghosts_world: Floats
    """(G, 5) boxes of actors that vanished in view shortly before: tracks there are not false."""
    extremes: dict[str, float]
    """Largest acceleration, jerk and overlap, by the column of the table `extremes`."""


class EventLog:
    """Finds the truth events of a run.

    Parameters
    ----------
    hidden_fraction_max
        An actor is in view if its visible fraction is larger, see `GradingConfig`.
    range_max_m
        Insertions and removals count up to this distance from the ego [m].
    delivered_m
        Distance up to which the traffic source delivers actors [m].
    """

    def __init__(self, hidden_fraction_max: float, range_max_m: float, delivered_m: float) -> None:
        self._hidden = hidden_fraction_max
        self._range = min(range_max_m, delivered_m - FRINGE_M)
        self._motion = MotionHistory()
        self._episodes = Episodes()
        self._presence = Presence()
        self._events: list[TruthEvent] = []
        self._last: tuple[WorldFrame, Bodies] | None = None

    def add(self, frame: WorldFrame, truth: ScanTruth) -> FrameEvents:
        """Find the events of one frame."""
        bodies = Bodies.of(frame)
        motion = self._motion.add(bodies)
        pairs = overlaps(bodies)
        jumps = np.flatnonzero(is_jump(motion)).tolist()
        began = [self._presence.jumped(frame, bodies, row, float(motion.jump_m[row])) for row in jumps]
        began += self._presence.add(frame, bodies, self._in_view(bodies, truth))
        before = self._last[1] if self._last else bodies
        began += self._episodes.collisions(frame, bodies, before, frame.collisions)
        began += self._episodes.overlaps(frame, bodies, pairs)
        began += self._episodes.violations(frame, bodies, motion)
        self._events += began
        self._last = frame, bodies
        masked = self._presence.masked(bodies)
        masked[pairs.first] = masked[pairs.second] = True
        acceleration, jerk, _ = motion.quantities.max(axis=0).tolist()
        return FrameEvents(
            began=began,
            masked=masked[EGO_ROW + 1 :],
            ghosts_world=self._presence.ghosts(frame.time),
            extremes={
                "acceleration_max_mps2": acceleration,
                "jerk_max_mps3": jerk,
                "overlap_max_m2": _largest(pairs),
            },
        )

    def end(self, collisions: tuple[Collision, ...]) -> None:
        """Add the collisions of the ego by which the run ended, to the last frame."""
        if self._last:
            frame, bodies = self._last
            self._events += self._episodes.collisions(frame, bodies, bodies, collisions)

    def table(self) -> pd.DataFrame:
        """Return the table `events`."""
        return event_table(self._events)

    def _in_view(self, bodies: Bodies, truth: ScanTruth) -> Bools:
        """(M,) mask of the actors that the LIDARs see, in range."""
        offset = bodies.pose_world[:, :2] - bodies.pose_world[EGO_ROW, :2]
        away = np.hypot(offset[:, 0], offset[:, 1])
        seen = np.append(False, (truth.hits > 0) & (truth.visible_fraction > self._hidden))
        return seen & (away <= self._range)


def _largest(pairs: Overlaps) -> float:
    return float(pairs.area.max()) if len(pairs.area) else 0.0
