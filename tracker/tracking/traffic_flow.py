"""Traffic flow: the direction of a vehicle that has not moved, from the directions of its neighbours and the ego."""

from dataclasses import dataclass

import numpy as np

from tracker.arrays import Floats, Ints
from tracker.geometry import rotate


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

    def without(self, track_id: int) -> "TrafficFlow":
        """Return the flow beside one track."""
        others = self.id != track_id
        return TrafficFlow(self.id[others], self.position[others], self.heading[others], self.forward, self.config)

    def axis_log_odds(self, place: Floats, heading: float) -> float:
        """Return the log-odds that a vehicle at `place` (2,) [m] is parallel to a heading [rad], not across."""
        weight = np.exp(-np.hypot(*(self.position - place).T) / self.config.range_m)
        own = self.config.ego_log_odds * np.cos(2.0 * (self.forward - heading))
        return float(own + self._neighbours(weight, np.cos(2.0 * (self.heading - heading))))

    def front_log_odds(self, place: Floats, heading: float) -> float:
        """Return the log-odds that a vehicle at `place` (2,) [m] faces a heading [rad], not the opposite one."""
        along, across = rotate(self.position - place, -heading).T
        weight = np.exp(-np.abs(along) / self.config.range_m - 0.5 * (across / self.config.lane_m) ** 2)
        own = self.config.ego_log_odds * np.cos(self.forward - heading)
        return float(own + self._neighbours(weight, np.cos(self.heading - heading)))

    def _neighbours(self, weight: Floats, agreement: Floats) -> float:
        """Return the log-odds of neighbours with weights (K,) and agreements (K,) from -1 to 1."""
        total = float(weight @ agreement) / (self.config.neighbour_min + float(weight.sum()))
        return self.config.neighbour_log_odds * total
