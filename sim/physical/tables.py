"""Tables and rings by the number of a road user, and how they grow."""

from typing import Any

import numpy as np
import numpy.typing as npt

from sim.articulation import hitch
from sim.cast import Member
from sim.physical.kernels.records import Builds, Led, Said
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
            present=np.zeros((window, 0), np.bool_),
            changes_lane=np.zeros((window, 0), np.bool_),
            raw=np.zeros((window, 0, 3)),
            path=np.zeros((window, 0, 3)),
            speed=np.zeros((window, 0)),
        )
        self.led = Led(
            state=np.zeros((0, 10)),
            settled=np.zeros(0, np.int64),
            since=np.zeros(0, np.int64),
            trail=np.zeros((trail, 0, 6)),
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
            self.led.settled[member.id] = -2
            self._met.add(member.id)

    def _grow(self, room: int) -> None:
        self.builds = Builds(*(_grown(column, 0, room) for column in self.builds))
        self.said = Said(*(_grown(ring, 1, room) for ring in self.said))
        led = self.led
        self.led = Led(
            state=_grown(led.state, 0, room),
            settled=_grown(led.settled, 0, room),
            since=_grown(led.since, 0, room),
            trail=_grown(led.trail, 1, room),
        )


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


def _grown(array: npt.NDArray[Any], axis: int, room: int) -> npt.NDArray[Any]:
    """Return the array with so much room along an axis, the new filled with zeros."""
    return np.pad(array, [(0, room - array.shape[axis] if a == axis else 0) for a in range(array.ndim)])
