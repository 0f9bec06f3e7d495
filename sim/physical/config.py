"""How the physical truth layer smooths."""

from dataclasses import dataclass


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
        if not (self.smoothing_s >= 0 and self.lane_change_s > 0 and self.lookahead_s >= 0):
            raise ValueError("smoothing_s and lookahead_s must not be negative, lane_change_s must be positive")
