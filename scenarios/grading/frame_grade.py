"""What one frame's grading knows: who is graded, which track and which box belongs to whom, and how far off it is."""

from dataclasses import dataclass

from scenarios.arrays import Bools, Floats, Ints


@dataclass(frozen=True, slots=True, eq=False)
class FrameGrade:
    """Verdicts of one frame for A actors, T tracks and B boxes; `NO_ACTOR` and NaN where there is none."""

    graded: Bools
    """(A,) the actor is a vehicle near enough, with enough points of its own, and not bent."""
    points: Ints
    """(A,) scan points that lie on the actor."""
    track_actor: Ints
    """(T,) id of the actor each track follows."""
    track_heading_error: Floats
    """(T,) track minus truth, modulo a full turn, in (-pi, pi] [rad]."""
    box_actor: Ints
    """(B,) id of the graded actor that owns most points of the box's segment."""
    box_heading_error: Floats
    """(B,) box minus truth, modulo a quarter turn, in (-pi/4, pi/4] [rad]."""
