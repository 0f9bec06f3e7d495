"""Lives of SUMO's road users: whoever SUMO puts elsewhere, rather than letting it drive there, goes on as a new member.

So nobody streaks across the map, or slides sideways into a parking space. A step to the next lane is no new life: the
physical layer makes a lane change of it.
"""

import math
from collections.abc import Callable
from typing import Any

from sim.roster import Member, Roster
from sim.world import Kind

LEAP = 6.0
"""[m] Farther than this beyond what its speed allows, nobody changes lanes in one step."""
PARKING_LEAP = 0.5
"""[m] The same for the middle of who starts or ends parking."""
PARKING_SPEED = 1.0
"""[m/s] Whoever is faster has left its parking space."""

Body = tuple[Kind, tuple[float, float, float]]
Point = tuple[float, float]


class MemberNames:
    """Vehicles, or persons: which member a name of SUMO's stands for at present.

    Parameters
    ----------
    cast
        Takes in the members.
    label
        Tells these names from the other domain's.
    body
        Returns kind and size [m] of a name; asked once.
    """

    def __init__(self, cast: Roster, label: str, body: Callable[[str], Body]):
        self._cast = cast
        self._label = label
        self._body = body
        self._members: dict[str, Member] = {}
        self._lives: dict[str, int] = {}
        self._before: dict[str, tuple[Point, Point]] = {}
        self._now: dict[str, tuple[Point, Point]] = {}

    def knows(self, name: str) -> bool:
        """Whether anybody has lived under the name."""
        return name in self._members

    def member(self, name: str) -> Member:
        """Return who lives under the name, cast if need be."""
        member = self._members.get(name)
        if member is None:
            kind, size = self._body(name)
            member = self._members[name] = self._cast.enter((self._label, name), kind, size, name)
        return member

    def renew(self, name: str) -> None:
        """Begin another life of the same body under the name."""
        past, life = self._members[name], self._lives.get(name, 1) + 1
        key, label = (self._label, name, life), f"{name}#{life}"
        self._members[name] = self._cast.enter(key, past.kind, past.size, label, past.reflectivity)
        self._lives[name] = life
        self._now.pop(name, None)  # it did not come from there

    def next_frame(self) -> None:
        """Begin a frame: what was seen since the last call is how things were."""
        self._before, self._now = self._now, {}

    def seen(self, name: str, front: Point, centre: Point, way: float, parks: bool) -> Member:
        """Return who is there in this frame: the member of the frame before, or its next life if it was put there.

        Parameters
        ----------
        name
            SUMO's.
        front, centre
            Of its bumper, which SUMO drives, and of its box, which also moves when the body is turned into a space [m].
        way
            How far its speed takes it in a frame [m].
        parks
            Whether it starts or ends parking.
        """
        before = self._before.get(name)
        if before is not None:
            moved = math.dist(centre, before[1]) if parks else math.dist(front, before[0])
            if moved > way + (PARKING_LEAP if parks else LEAP):
                self.renew(name)
        self._now[name] = front, centre
        return self._members[name]


class Parking:
    """Follows who starts or ends parking. SUMO says so up to a step before it moves them.

    Parameters
    ----------
    simulation
        libsumo's domain of the simulation.
    """

    def __init__(self, simulation: Any):
        self._simulation = simulation
        self._names: set[str] = set()

    def names(self, speeds: Callable[[str], float | None]) -> list[str]:
        """Return who may be put into a space or out of it in this step.

        Parameters
        ----------
        speeds
            Returns the speed [m/s] of a vehicle that is near, None of others.
        """
        said = self._simulation
        self._names.update(said.getParkingStartingVehiclesIDList(), said.getParkingEndingVehiclesIDList())
        known = {name: speeds(name) for name in self._names}
        self._names = {name for name, speed in known.items() if speed is not None and speed < PARKING_SPEED}
        return sorted(self._names)
