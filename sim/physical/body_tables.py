"""Tables and rings, a row for each road user that is near, and how they grow."""

from typing import Any

import numpy as np
import numpy.typing as npt

from sim.arrays import Ints
from sim.articulation import hitch
from sim.physical.kernels.records import NEVER, Builds, Led, Said
from sim.physical.limits import YAW_RATE_ON_FOOT, YAW_RATE_ON_WHEELS
from sim.roster import EGO_ID, Member
from sim.world import Kind

REAR_AXLE = 0.8
"""Where the rear axle is, as a share of the length behind the front bumper: of cars and, roughly, of all others."""
SHORTEST_LEAD = 0.3
"""[m] At least from rear axle to front, for those who walk."""


class Tables:
    """All that the layer knows. Rows of those who are gone are given to others, so that a long run takes no more room.

    Parameters
    ----------
    window, trail
        Frames that are kept of what the simulator said, and of the paths.
    """

    def __init__(self, window: int, trail: int):
        nobody = (np.zeros(0) for _ in Builds._fields)
        self.builds = Builds(*nobody)
        self.said = Said(
            frame=np.zeros((0, window), np.int64),
            changes_lane=np.zeros((0, window), np.bool_),
            raw=np.zeros((0, window, 3)),
            path=np.zeros((0, window, 3)),
            speed=np.zeros((0, window)),
        )
        self.led = Led(
            state=np.zeros((0, 10)),
            settled=np.zeros(0, np.int64),
            since=np.zeros(0, np.int64),
            trail=np.zeros((0, trail, 6)),
        )
        self._row: dict[int, int] = {}
        self._free: list[int] = []
        self._last = np.zeros(0, np.int64)

    def rows(self, members: list[Member], frame: int) -> Ints:
        """Return the rows (N,) of members in a frame that is pushed; they are given one where they have none."""
        for member in members:
            if member.id not in self._row:
                self._row[member.id] = self._room_for(member)
        rows = np.array([self._row[member.id] for member in members])
        self._last[rows] = frame
        return rows

    def forget(self, frame: int) -> None:
        """Take the rows back of those who were last pushed before a frame."""
        for id in [id for id, row in self._row.items() if self._last[row] < frame]:
            self._free.append(self._row.pop(id))

    def _room_for(self, member: Member) -> int:
        """Return a free row, with the member's build entered."""
        if not self._free:
            room = 2 * len(self._last) + 64
            self._free = list(range(room - 1, len(self._last) - 1, -1))
            self._grow(room)
        row = self._free.pop()
        for column, value in zip(self.builds, _build(member), strict=True):
            column[row] = value
        self.said.frame[row] = NEVER
        self.led.settled[row] = NEVER
        return row

    def _grow(self, room: int) -> None:
        self.builds = Builds(*(_grown(column, room) for column in self.builds))
        self.said = Said(*(_grown(ring, room) for ring in self.said))
        self.led = Led(*(_grown(column, room) for column in self.led))
        self._last = _grown(self._last, room)


def _build(member: Member) -> Builds:
    """Return the numbers of one body."""
    length = member.size[0]
    walks = member.kind is Kind.PEDESTRIAN
    lead = max(REAR_AXLE * length, SHORTEST_LEAD)
    turn = YAW_RATE_ON_FOOT if walks else YAW_RATE_ON_WHEELS
    if member.kind is not Kind.TRAILER_TRUCK or member.id == EGO_ID:  # an ego's record knows no bend
        return Builds(length, lead, lead - 0.5 * length, turn, 0.0, 0.0, 0.0)  # type: ignore[arg-type]  # of one body
    coupling = hitch(np.array([length]))
    drive, pin, axles = (float(at[0]) for at in (coupling.drive_axle, coupling.kingpin, coupling.trailer_axles))
    return Builds(length, drive, 0.0, turn, drive - pin, axles - pin, pin - 0.5 * length)  # type: ignore[arg-type]


def _grown(array: npt.NDArray[Any], room: int) -> npt.NDArray[Any]:
    """Return the array with so many rows, the new filled with zeros."""
    return np.concatenate([array, np.zeros((room - len(array), *array.shape[1:]), array.dtype)])
