"""Traffic flow: the direction of a vehicle that has not moved, from the directions of its neighbours and the ego."""

import math
from dataclasses import dataclass

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.records import NO_TRACK
from luxloop.tracker.tracking.kernels import traffic_flow as kernel


@dataclass(frozen=True, slots=True)
class FlowConfig:
    """Similarity of directions in traffic.

    Most vehicles drive parallel to their neighbours, and those of one lane in the same direction. The weights were
    estimated by logistic regression on training seeds.
    """

    ego_log_odds: float = 0.7
    """Log-odds that a vehicle without neighbours is parallel to the ego, not across."""
    neighbour_log_odds: float = 2.0
    """Log-odds for the same of many neighbours."""
    neighbour_min: float = 0.3
    """Weight of neighbours that has half of that effect."""
    range_m: float = 15.0
    """Distance at which the weight of a neighbour has fallen to 1/e [m]."""
    lane_m: float = 1.75
    """Standard deviation of the lateral distance within a lane [m]: half the width of a lane."""


@dataclass(frozen=True, slots=True, eq=False)
class TrafficFlow:
    """Positions and directions of K vehicles in the odometry frame."""

    id: Ints
    """(K,) tracks."""
    position: Floats
    """(K, 2) [m]."""
    heading: Floats
    """(K,) [rad]."""
    forward: float
    """Heading of the ego [rad]."""
    config: FlowConfig
    without_id: int = NO_TRACK
    """Track that does not count as a neighbour."""

    def without(self, track_id: int) -> "TrafficFlow":
        """Return the flow beside one track."""
        return TrafficFlow(self.id, self.position, self.heading, self.forward, self.config, without_id=track_id)

    def axis_log_odds(self, place: Floats, heading: float) -> float:
        """Return the log-odds that a vehicle at `place` (2,) [m] is parallel to a heading [rad], not across."""
        agreement = kernel.axis_agreement(*self._others, place, heading, self.config.range_m)
        own = self.config.ego_log_odds * math.cos(2.0 * (self.forward - heading))
        return own + self._neighbours(*agreement)

    def front_log_odds(self, place: Floats, heading: float) -> float:
        """Return the log-odds that a vehicle at `place` (2,) [m] faces a heading [rad], not the opposite one."""
        limits = self.config.range_m, self.config.lane_m
        agreement = kernel.front_agreement(*self._others, place, heading, *limits)
        own = self.config.ego_log_odds * math.cos(self.forward - heading)
        return own + self._neighbours(*agreement)

    @property
    def _others(self) -> tuple[Floats, Floats, Ints, int]:
        return self.position, self.heading, self.id, self.without_id

    def _neighbours(self, weight: float, agreement: float) -> float:
        """Return the log-odds of neighbours with a sum of weights, and of weighted agreements from -1 to 1."""
        return self.config.neighbour_log_odds * agreement / (self.config.neighbour_min + weight)
