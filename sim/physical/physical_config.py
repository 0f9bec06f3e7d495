"""How the physical truth layer smooths."""

from dataclasses import dataclass

LONGEST_S = 10.0
"""[s] Nobody plans, or takes to change lanes, for longer; the layer keeps all frames of that time."""


@dataclass(frozen=True, slots=True)
class PhysicalConfig:
    """Of the layer between a simulator's poses and the delivered motion."""

    smoothing_s: float = 1.2
    """[s] Half the width of the window over which positions are smoothed (a cubic B-spline). 0 switches it off. As far
    as the look-ahead falls short of it, the way ahead is guessed, straight on at constant speed; take 0.4 s then."""
    lane_change_s: float = 3.6
    """[s] that a lane change takes where the simulator jumps."""
    lookahead_s: float = 3.0
    """[s] that the simulator runs ahead of the delivered frames, so that bodies act before and not after. With a
    controlled ego it must be 0: a command cannot reach a simulator that is ahead."""

    def __post_init__(self) -> None:
        if not (0 <= self.smoothing_s <= LONGEST_S and 0 <= self.lookahead_s <= LONGEST_S):
            raise ValueError(f"smoothing_s and lookahead_s must lie between 0 and {LONGEST_S:.0f} s")
        if not 0 < self.lane_change_s <= LONGEST_S:
            raise ValueError(f"lane_change_s must be above 0 and at most {LONGEST_S:.0f} s")
