"""Control of the ego in SUMO."""

import math
from typing import Any

from luxloop.sim.source import EgoCommand, TrafficInputError

_SPEED_MODE = 0b1100110
"""SUMO's bit field for commanded speeds: acceleration (bit 1) and deceleration (2) respect the type's limits; safe
distances (0), right of way before (3) and within crossings (5), red lights (4) and speed limits (6) are ignored. The
bits 5 and 6 are inverted."""
_LANE_CHANGE_MODE = 0
"""No autonomous lane changes; commanded ones ignore other vehicles."""
_FOREVER_S = 1e9
"""[s]"""


class EgoControl:
    """Control of the ego. It keeps its lane from now on; SUMO drives it until the first speed command.

    Parameters
    ----------
    sumo
        The libsumo module, running.
    ego
        The ego's SUMO id.
    """

    def __init__(self, sumo: Any, ego: str):
        self._sumo = sumo
        self._ego = ego
        sumo.vehicle.setLaneChangeMode(ego, _LANE_CHANGE_MODE)

    def apply(self, command: EgoCommand) -> None:
        """Command speed and lane. See `luxloop.sim.source.TrafficSource.apply`."""
        if command.action is not None:
            raise TrafficInputError("action: SUMO's ego accepts no action; command speed_mps and lane")
        speed, lane = command.speed_mps, command.lane
        if speed is not None and not 0 <= speed < math.inf:
            raise TrafficInputError(f"speed_mps = {speed}: command a speed of 0 or more")
        if lane is not None:
            self._require_lane(lane)
            self._sumo.vehicle.changeLane(self._ego, int(lane), _FOREVER_S)
        if speed is not None:
            self._sumo.vehicle.setSpeedMode(self._ego, _SPEED_MODE)
            self._sumo.vehicle.setSpeed(self._ego, float(speed))

    def _require_lane(self, lane: int) -> None:
        """Reject a lane that is closed to the ego on its road, or on the next road while it is on a crossing."""
        sumo, ego = self._sumo, self._ego
        crossing = sumo.vehicle.getRoadID(ego).startswith(":")
        edge = sumo.vehicle.getRoute(ego)[sumo.vehicle.getRouteIndex(ego) + crossing]
        count, vehicle_class = sumo.edge.getLaneNumber(edge), sumo.vehicle.getVehicleClass(ego)
        open_lanes = [n for n in range(count) if _allows(sumo.lane, f"{edge}_{n}", vehicle_class)]
        if lane not in open_lanes:
            lanes = ", ".join(map(str, open_lanes))
            raise TrafficInputError(f'lane = {lane}: road "{edge}" has lanes {lanes} for {vehicle_class} vehicles')


def _allows(lanes: Any, name: str, vehicle_class: str) -> bool:
    """Return True if vehicles of a class may use a lane; SUMO's empty list means all classes."""
    allowed = lanes.getAllowed(name)
    return not allowed or vehicle_class in allowed
