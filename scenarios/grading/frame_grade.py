"""Grade of one frame: graded actors, and the actor and heading error of each track and box."""

from dataclasses import dataclass, field

from luxloop.scenarios.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading.truth_events.truth_event import TruthEvent


@dataclass(frozen=True, slots=True, eq=False)
class FrameGrade:
    """Grade of one frame with A actors, T tracks and B boxes. Unassigned tracks and boxes have `NO_ACTOR` and NaN."""

    graded: Bools
    """(A,) the actor is a vehicle in range, with enough points on it, and not a bent truck."""
    points: Ints
    """(A,) scan points that lie on the actor."""
    track_actor: Ints
    """(T,) id of the actor that each track follows."""
    track_heading_error: Floats
    """(T,) heading of the track minus truth, modulo a full turn, in (-pi, pi] [rad]."""
    box_actor: Ints
    """(B,) id of the graded actor with most points of the box's segment."""
    box_heading_error: Floats
    """(B,) heading of the box minus truth, modulo a quarter turn, in (-pi/4, pi/4] [rad]."""
    events: list[TruthEvent] = field(default_factory=list)
    """Events of the ground truth that begin in this frame."""
