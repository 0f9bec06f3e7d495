"""Configuration of the physical truth layer."""

from dataclasses import dataclass

LONGEST_S = 10.0
"""[s] Upper limit of all durations; the layer keeps all frames of that time."""


@dataclass(frozen=True, slots=True)
class PhysicalConfig:
    """Layer between a simulator's poses and the delivered motion."""

    smoothing_s: float = 1.2
    """[s] Half the width of the window over which positions are smoothed (a cubic B-spline). 0 disables smoothing.
    Beyond the look-ahead, the path is extrapolated straight at constant speed; use 0.4 s with a short look-ahead."""
    lane_change_s: float = 3.6
    """[s] Duration of a lane change that the simulator makes in one step."""
    lookahead_s: float = 3.0
    """[s] Time by which the simulator runs ahead of the delivered frames, so that motions can begin before the
    simulator's steps. Must be 0 with a controlled ego, since commands cannot reach a simulator that is ahead."""

    def __post_init__(self) -> None:
        if not (0 <= self.smoothing_s <= LONGEST_S and 0 <= self.lookahead_s <= LONGEST_S):
            raise ValueError(f"smoothing_s and lookahead_s must be between 0 and {LONGEST_S:.0f} s")
        if not 0 < self.lane_change_s <= LONGEST_S:
            raise ValueError(f"lane_change_s must be above 0 and at most {LONGEST_S:.0f} s")
