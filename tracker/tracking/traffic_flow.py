"""Agreement of the directions of neighbours with a heading, see `luxloop.tracker.tracking.traffic_flow`."""

from dataclasses import dataclass, replace

from luxloop import elementary
from luxloop.arrays import Bools, Floats, Ints
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
    front_known: Bools,
    ids: Ints,
    without_id: int,
    place: Floats,
    heading: float,
    range_m: float,
    lane_m: float,
) -> tuple[float, float]:
    """Return the sum of the weights of those of K neighbours whose front is known, and their agreement with a front.

    Neighbours at (K, 2) [m] have directions (K,), a mask (K,) of known fronts, `ids` (K,) of which one does not count,
    and weights that decrease along the heading with the distance from the place (2,), and across it within a lane.
    """
    total, agreement = 0.0, 0.0
    cos, sin = elementary.cos(heading), elementary.sin(heading)
    for k in range(len(direction)):
        if ids[k] == without_id or not front_known[k]:
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

CARRIAGEWAY_M = 5.25
"""Lateral distance within which a vehicle may be in another lane of the ego's carriageway [m]: one and a half lanes."""

SIDE_STREET_M = 10.0
"""Lateral distance beyond which a vehicle across the ego's heading is on a side street [m]: parking bays end there."""

KEEPS_RIGHT_LOG_ODDS = 0.6
"""Log-odds that traffic keeps to the right: about 65 % of people live in countries where it does."""

ONCOMING_LOG_ODDS = 1.0
"""Evidence of one oncoming vehicle that passes on the left: some do so on the other side, at crossings."""

KEEPS_LOG_ODDS_MAX = 5.0
"""Maximum log-odds that traffic keeps to one side."""

ONCOMING_M = (1.75, 10.0)
"""Lateral distance from the ego of oncoming vehicles that show the side [m]: beyond the ego's lane, on its road."""

ONCOMING_COS = -0.95
"""Maximum cosine of the angle between their headings and that of the ego: 18 degrees."""


def left_of(ego_pose: Floats, place: Floats) -> float:
    """Return the lateral distance of a place (2,) [m] from an ego at x, y [m] and heading [rad] (3,), positive left."""
    x, y, forward = ego_pose.tolist()
    left_m: float = elementary.cos(forward) * (place.item(1) - y) - elementary.sin(forward) * (place.item(0) - x)
    return left_m


@dataclass(slots=True)
class TrafficSide:
    """Belief that traffic keeps to the right, from the oncoming vehicles that were seen to move."""

    log_odds: float = KEEPS_RIGHT_LOG_ODDS
    _counted: frozenset[int] = frozenset()

    @property
    def keeps_right(self) -> float:
        """Expected side, from 1 for the right to -1 for the left."""
        return 2.0 / (1.0 + elementary.exp(-self.log_odds)) - 1.0

    def observe(self, id: Ints, position: Floats, heading: Floats, ego_pose: Floats) -> None:
        """Count each oncoming vehicle once; vehicles at (K, 2) [m] are known to move along headings (K,)."""
        low, high = ONCOMING_M
        counted = set[int]()
        for number, place, direction in zip(id.tolist(), position, heading.tolist(), strict=True):
            left_m = left_of(ego_pose, place)
            if number in self._counted:
                counted.add(number)
            elif low < abs(left_m) < high and elementary.cos(direction - ego_pose.item(2)) < ONCOMING_COS:
                counted.add(number)
                total = self.log_odds + (ONCOMING_LOG_ODDS if left_m > 0.0 else -ONCOMING_LOG_ODDS)
                self.log_odds = min(max(total, -KEEPS_LOG_ODDS_MAX), KEEPS_LOG_ODDS_MAX)
        self._counted = frozenset(counted)


@dataclass(frozen=True, slots=True, eq=False)
class TrafficFlow:
    """Positions and directions of K vehicles in the odometry frame, and the ego's."""

    id: Ints
    """(K,) tracks."""
    position: Floats
    """(K, 2) [m]."""
    heading: Floats
    """(K,) [rad]."""
    front_known: Bools
    """(K,) mask of vehicles whose front was confirmed by their motion; of the others only the axis is known."""
    ego_pose: Floats
    """(3,) x, y [m] and heading [rad] of the ego."""
    keeps_right: float = 1.0
    """Expected side of traffic, from 1 for the right to -1 for the left."""
    without_id: int = NO_TRACK
    """Track that does not count as a neighbour."""

    def without(self, track_id: int) -> "TrafficFlow":
        """Return the flow beside one track."""
        return replace(self, without_id=track_id)

    def axis_log_odds(self, place: Floats, heading: float) -> float:
        """Return the log-odds that a vehicle at `place` (2,) [m] is parallel to a heading [rad], not across."""
        others = self.position, self.heading, self.id, self.without_id
        agreement = axis_agreement(*others, place, heading, NEIGHBOUR_RANGE_M)
        own = EGO_LOG_ODDS * elementary.cos(2.0 * (self.ego_pose.item(2) - heading))
        return own + self._neighbours(*agreement)

    def front_log_odds(self, place: Floats, heading: float) -> float:
        """Return the log-odds that a vehicle at `place` (2,) [m] faces a heading [rad], not the opposite one."""
        others = self.position, self.heading, self.front_known, self.id, self.without_id
        agreement = front_agreement(*others, place, heading, NEIGHBOUR_RANGE_M, LANE_STD_M)
        direction = elementary.rotation(self.ego_pose.item(2) - heading)
        own = EGO_LOG_ODDS * (self._expected(place) * direction).real
        return own + self._neighbours(*agreement)

    def _expected(self, place: Floats) -> complex:
        """Return the expected directions of vehicles along and across the ego's heading at a place (2,) [m].

        Vehicles beside the ego may be in another lane of its carriageway. Farther away, those on one side face as the
        ego does, those on the other one oppose it. Those that stand across, on a side street, wait for the junction.
        """
        left_m = left_of(self.ego_pose, place)
        if abs(left_m) <= CARRIAGEWAY_M:
            return 1.0 + 0.0j
        side = 1.0 if left_m > 0.0 else -1.0
        return complex(-side * self.keeps_right, -side if abs(left_m) > SIDE_STREET_M else 0.0)

    def _neighbours(self, weight: float, agreement: float) -> float:
        """Return the log-odds of neighbours with a sum of weights, and of weighted agreements from -1 to 1."""
        return NEIGHBOUR_LOG_ODDS * agreement / (NEIGHBOUR_MIN + weight)
