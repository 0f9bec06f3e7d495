"""Tables and rings by the number of a road user, and how they grow."""

from typing import Any

import numpy as np
import numpy.typing as npt

from sim.articulation import hitch
from sim.cast import Member
from sim.physical.kernels.records import NEVER, Builds, Led, Said
from sim.physical.limits import YAW_RATE_ON_FOOT, YAW_RATE_ON_WHEELS
from sim.world import Kind

REAR_AXLE = 0.8
"""Where the rear axle is, as a share of the length behind the front bumper: of cars and, roughly, of all others."""
SHORTEST_LEAD = 0.3
"""[m] At least from rear axle to front, for those who walk."""


class Tables:
    """All that the layer knows, with room for as many road users as have been met.

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
        self._met: set[int] = set()

    def meet(self, members: list[Member]) -> None:
        """Enter the builds of those among members, by ascending number, who are new."""
        new = [member for member in members if member.id not in self._met]
        if new and new[-1].id >= len(self.builds.length):
            self._grow(2 * (new[-1].id + 1))
        for member in new:
            for column, value in zip(self.builds, _build(member), strict=True):
                column[member.id] = value
            self.said.frame[member.id] = NEVER
            self.led.settled[member.id] = NEVER
            self._met.add(member.id)

    def _grow(self, room: int) -> None:
        self.builds = Builds(*(_grown(column, room) for column in self.builds))
        self.said = Said(*(_grown(ring, room) for ring in self.said))
        self.led = Led(*(_grown(column, room) for column in self.led))


def _build(member: Member) -> Builds:
    """Return the numbers of one body."""
    length = member.size[0]
    walks = member.kind is Kind.PEDESTRIAN
    lead = max(REAR_AXLE * length, SHORTEST_LEAD)
    turn = YAW_RATE_ON_FOOT if walks else YAW_RATE_ON_WHEELS
    if member.kind is not Kind.TRAILER_TRUCK:
        return Builds(length, lead, lead - 0.5 * length, turn, 0.0, 0.0, 0.0)  # type: ignore[arg-type]  # of one body
    coupling = hitch(np.array([length]))
    drive, pin, axles = (float(at[0]) for at in (coupling.drive_axle, coupling.kingpin, coupling.trailer_axles))
    return Builds(length, drive, 0.0, turn, drive - pin, axles - pin, pin - 0.5 * length)  # type: ignore[arg-type]


def _grown(array: npt.NDArray[Any], room: int) -> npt.NDArray[Any]:
    """Return the array with so many rows, the new filled with zeros."""
    return np.concatenate([array, np.zeros((room - len(array), *array.shape[1:]), array.dtype)])
