"""Manoeuvres into and out of stops beside the road, which SUMO makes in one step.

A vehicle that stops with `parking="true"` outside of a parking area halts on its lane; SUMO then places it 3.2 m to the
kerb side of the outermost lane, and back at departure. A driver turns off before the stop and merges behind it. The
shift between lane and stop is therefore spread over the distance driven, so that a standing vehicle stays where it is.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from luxloop import elementary
from luxloop.sim.physical.lane_change import minimum_jerk
from luxloop.sim.sumo.parking import arc_lengths, offset_line, point_along

BESIDE_M = 3.2
"""[m] Offset of the stop from the outermost lane: SUMO_const_laneWidth in `MSVehicle::getPosition` of SUMO 1.28."""
TAPER = 8.0
"""Distance driven per metre of lateral shift. The tapers of bus bays are at least 5:1 at the entry and 3:1 at the exit
(AASHTO, A Policy on Geometric Design of Highways and Streets, 2011, section 4.19); at 8 m/s, 8:1 takes 1.8 m/s^2."""
STRAIGHT = 0.5
"""Distance driven along the kerb before the stop, by the vehicle's length: its rear follows the front inwards."""
LOOK_S = 1.0
"""[s] Time between two looks at the next stop of a vehicle."""

_PARKING, _IN_PARKING_AREA = 1, 64
"""Bits of SUMO's stop flags."""


@dataclass(slots=True)
class _Manoeuvre:
    """State of the manoeuvre of one vehicle into and out of a stop."""

    edge: str
    lane: int
    end: float
    """Position of the stop's end on the lane [m]."""
    ahead: float
    left: float
    """Place of the stop relative to the lane [m]."""
    straight: float
    done: float = 0.0
    """Progress: 0 on the lane, 1 in the stop."""
    parked: bool = False
    leaving: bool = False

    @property
    def taper(self) -> float:
        return TAPER * abs(self.left)


class RoadsideStops:
    """Shifts of the vehicles near the ego from the places that SUMO reports.

    Parameters
    ----------
    sumo
        The libsumo module, running.
    dt
        Time between frames [s].
    left_hand
        Traffic keeps to the left.
    """

    def __init__(self, sumo: Any, dt: float, *, left_hand: bool):
        self._vehicle = sumo.vehicle
        self._lanes = sumo.lane
        self._dt = dt
        self._right = -BESIDE_M if left_hand else BESIDE_M
        self._every = max(round(LOOK_S / dt), 1)
        self._frame = 0
        self._look_at: dict[str, int] = {}
        self._manoeuvres: dict[str, _Manoeuvre] = {}

    def shifts(self, speeds: Mapping[str, float]) -> dict[str, tuple[float, float]]:
        """Return the shifts, ahead and to the left [m], of the vehicles that are shifted.

        Parameters
        ----------
        speeds
            Speed [m/s] of each vehicle near the ego. Call it once per frame.
        """
        self._frame += 1
        for name in speeds:
            if self._look_at.get(name, 0) <= self._frame:
                self._look_at[name] = self._frame + self._every
                self._look(name)
        shifts = {}
        for name, manoeuvre in list(self._manoeuvres.items()):
            if name not in speeds:
                del self._manoeuvres[name]
                continue
            self._advance(name, manoeuvre, abs(speeds[name]) * self._dt)
            share = minimum_jerk(manoeuvre.done) - (1.0 if manoeuvre.parked else 0.0)
            if share:
                shifts[name] = share * manoeuvre.ahead, share * manoeuvre.left
            if manoeuvre.leaving and manoeuvre.done <= 0.0:
                del self._manoeuvres[name]
        return shifts

    def _look(self, name: str) -> None:
        """Begin the manoeuvre for the next stop of a vehicle, or give it up if the stop is cancelled."""
        stop = next(iter(self._vehicle.getStops(name, 1)), None)
        if stop is not None and (not stop.stopFlags & _PARKING or stop.stopFlags & _IN_PARKING_AREA):
            stop = None
        current = self._manoeuvres.get(name)
        if current is not None:
            current.leaving |= stop is None and not current.parked
        elif stop is not None:
            edge, _, lane = stop.lane.rpartition("_")
            ahead, left = self._place_beside(edge, int(lane), stop.endPos)
            straight = STRAIGHT * self._vehicle.getLength(name)
            manoeuvre = _Manoeuvre(edge, int(lane), stop.endPos, ahead, left, straight)
            if self._vehicle.isStoppedParking(name):
                manoeuvre.done, manoeuvre.parked = 1.0, True
            self._manoeuvres[name] = manoeuvre

    def _advance(self, name: str, manoeuvre: _Manoeuvre, travelled: float) -> None:
        """Advance a manoeuvre by a frame."""
        parked = self._vehicle.isStoppedParking(name)
        manoeuvre.leaving |= manoeuvre.parked and not parked
        manoeuvre.parked = parked
        if parked:
            return
        if manoeuvre.leaving:
            manoeuvre.done = max(manoeuvre.done - travelled / manoeuvre.taper, 0.0)
            return
        left = self._vehicle.getDrivingDistance(name, manoeuvre.edge, manoeuvre.end, manoeuvre.lane)
        if manoeuvre.done > 0.0 or 0.0 <= left <= manoeuvre.taper + manoeuvre.straight:
            manoeuvre.done = min(manoeuvre.done + travelled / manoeuvre.taper, 1.0)

    def _place_beside(self, edge: str, lane: int, end: float) -> tuple[float, float]:
        """Return the place beside the outermost lane, relative to a position `end` [m] on a lane, ahead and left.

        SUMO measures the position along the shifted outermost lane, which is longer or shorter in a bend.
        """
        shape, outermost = (np.array(self._lanes.getShape(f"{edge}_{index}"))[:, :2] for index in (lane, 0))
        along = end * float(arc_lengths(shape)[-1]) / self._lanes.getLength(f"{edge}_{lane}")
        point = point_along(shape, along)
        x, y = (point_along(offset_line(outermost, self._right), along) - point).tolist()
        before = point_along(shape, along - 1.0)
        course = elementary.atan2(point[1] - before[1], point[0] - before[0])
        cos, sin = elementary.cos(course), elementary.sin(course)
        return x * cos + y * sin, y * cos - x * sin
