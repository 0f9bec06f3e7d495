"""Agreement of the directions of neighbours with a heading, see `luxloop.tracker.tracking.traffic_flow`."""

from dataclasses import dataclass

from luxloop import elementary
from luxloop.arrays import Floats, Ints
from luxloop.compiled import kernel
from luxloop.tracker.records import NO_TRACK


@kernel()
def axis_agreement(
    position: Floats,
    direction: Floats,
    ids: Ints,
    without_id: int,
    place: Floats,
    heading: float,
    range_m: float,
) -> tuple[float, float]:
    """Return the sum of the weights of K neighbours, and that of their weighted agreements with an axis.

    Neighbours at (K, 2) [m] have directions (K,), `ids` (K,) of which one does not count, and weights that decrease
    with the distance from the place (2,).
    """
    total, agreement = 0.0, 0.0
    for k in range(len(direction)):
        if ids[k] == without_id:
            continue
        weight = elementary.exp(-elementary.hypot(position[k, 0] - place[0], position[k, 1] - place[1]) / range_m)
        total += weight
        agreement += weight * elementary.cos(2.0 * (direction[k] - heading))
    return total, agreement


@kernel()
def front_agreement(
    position: Floats,
    direction: Floats,
    ids: Ints,
    without_id: int,
    place: Floats,
    heading: float,
    range_m: float,
    lane_m: float,
) -> tuple[float, float]:
    """Return the sum of the weights of K neighbours, and that of their weighted agreements with a front.

    Neighbours at (K, 2) [m] have directions (K,), `ids` (K,) of which one does not count, and weights that decrease
    along the heading with the distance from the place (2,), and across it within a lane.
    """
    total, agreement = 0.0, 0.0
    cos, sin = elementary.cos(heading), elementary.sin(heading)
    for k in range(len(direction)):
        if ids[k] == without_id:
            continue
        x, y = position[k, 0] - place[0], position[k, 1] - place[1]
        along, across = cos * x + sin * y, cos * y - sin * x
        weight = elementary.exp(-abs(along) / range_m - 0.5 * (across / lane_m) ** 2)
        total += weight
        agreement += weight * elementary.cos(direction[k] - heading)
    return total, agreement


EGO_LOG_ODDS = 0.7
"""Log-odds that a vehicle without neighbours is parallel to the ego, not across."""

NEIGHBOUR_LOG_ODDS = 2.0
"""Log-odds for the same of many neighbours."""

NEIGHBOUR_MIN = 0.3
"""Weight of neighbours that has half of that effect."""

NEIGHBOUR_RANGE_M = 15.0
"""Distance at which the weight of a neighbour has fallen to 1/e [m]."""

LANE_STD_M = 1.75
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
    without_id: int = NO_TRACK
    """Track that does not count as a neighbour."""

    def without(self, track_id: int) -> "TrafficFlow":
        """Return the flow beside one track."""
        return TrafficFlow(self.id, self.position, self.heading, self.forward, without_id=track_id)

    def axis_log_odds(self, place: Floats, heading: float) -> float:
        """Return the log-odds that a vehicle at `place` (2,) [m] is parallel to a heading [rad], not across."""
        agreement = axis_agreement(*self._others, place, heading, NEIGHBOUR_RANGE_M)
        own = EGO_LOG_ODDS * elementary.cos(2.0 * (self.forward - heading))
        return own + self._neighbours(*agreement)

    def front_log_odds(self, place: Floats, heading: float) -> float:
        """Return the log-odds that a vehicle at `place` (2,) [m] faces a heading [rad], not the opposite one."""
        limits = NEIGHBOUR_RANGE_M, LANE_STD_M
        agreement = front_agreement(*self._others, place, heading, *limits)
        own = EGO_LOG_ODDS * elementary.cos(self.forward - heading)
        return own + self._neighbours(*agreement)

    @property
    def _others(self) -> tuple[Floats, Floats, Ints, int]:
        return self.position, self.heading, self.id, self.without_id

    def _neighbours(self, weight: float, agreement: float) -> float:
        """Return the log-odds of neighbours with a sum of weights, and of weighted agreements from -1 to 1."""
        return NEIGHBOUR_LOG_ODDS * agreement / (NEIGHBOUR_MIN + weight)
