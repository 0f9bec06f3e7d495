"""Identity of road users that SUMO moves discontinuously.

A step to the next lane is no discontinuity: the physical layer turns it into a lane change. Where SUMO skips a short
way, such as that of people across a junction without a crossing, the road user keeps its member and begins a new
stretch of motion. One that teleports out of a jam, or is moved into a parking area, continues as a new member.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from luxloop.sim.roster import EGO_ID, Member, Roster
from luxloop.sim.world import Kind

TELEPORT_DISTANCE = 6.0
"""[m] A step that exceeds the distance by speed by more than this is not a lane change."""
SKIPPED_S = 30.0
"""[s] Longest way that SUMO may skip in one step without a change of identity, by the time to cover it: people need
30 s for the diagonal of a junction of 30 m by 30 m at 1.4 m/s."""
WALKING_SPEED = 1.4
"""[m/s] Least speed assumed for a skipped way, that of people on foot (Weidmann, "Transporttechnik der Fussgaenger",
ETH Zurich 1993: 1.34 m/s)."""
PARKING_DISTANCE = 0.5
"""[m] The same limit for the centre of a vehicle that starts or ends parking."""
PARKING_SPEED = 1.0
"""[m/s] A faster vehicle has left its parking space."""

Body = tuple[Kind, tuple[float, float, float]]
Point = tuple[float, float]


class MemberNames:
    """Current members by SUMO name, either of vehicles or of persons.

    Parameters
    ----------
    roster
        Registers the members.
    label
        Distinguishes these names from those of the other kind.
    body
        Returns kind and size [m] of a name; called once per name.
    dt
        Time between frames [s].
    """

    def __init__(self, roster: Roster, label: str, body: Callable[[str], Body], dt: float):
        self._roster = roster
        self._label = label
        self._body = body
        self._dt = dt
        self._members: dict[str, Member] = {}
        self._generations: dict[str, int] = {}
        self._previous: dict[str, tuple[Point, Point]] = {}
        self._current: dict[str, tuple[Point, Point]] = {}

    def knows(self, name: str) -> bool:
        """Return True if the name has a member."""
        return name in self._members

    def id_of(self, name: str) -> int | None:
        """Return the id of the name's current member, None without one."""
        member = self._members.get(name)
        return None if member is None else member.id

    def member(self, name: str) -> Member:
        """Return the current member of the name; add one if necessary.

        Raises
        ------
        TrafficInputError
            As `Roster.add`: SUMO accepts types of infinite length.
        """
        member = self._members.get(name)
        if member is None:
            kind, size = self._body(name)
            member = self._members[name] = self._roster.add((self._label, name), kind, size, name)
        return member

    def start_new_member(self, name: str) -> None:
        """Continue the same body under the name as a new member."""
        previous, generation = self._members[name], self._generations.get(name, 1) + 1
        key, label = (self._label, name, generation), f"{name}#{generation}"
        self._members[name] = self._roster.add(key, previous.kind, previous.size, label, previous.reflectivity)
        self._generations[name] = generation
        self._current.pop(name, None)  # the new member has no previous position

    def start_new_stretch(self, name: str) -> None:
        """Continue the member at another place, as a new stretch of its motion."""
        member = self._members[name]
        self._members[name] = replace(member, stretch=member.stretch + 1)

    def next_frame(self) -> None:
        """Begin a frame: the positions since the last call become the previous ones."""
        self._previous, self._current = self._current, {}

    def observe(self, name: str, front: Point, centre: Point, travelled: float, parking: bool) -> Member:
        """Return the member in this frame: a new stretch or a new member if SUMO moved it discontinuously.

        The ego never begins a new stretch: its odometry would be wrong.

        Parameters
        ----------
        name
            SUMO's name.
        front, centre
            Front bumper, whose motion SUMO simulates, and box centre [m]. Turning into a parking space moves the
            centre.
        travelled
            Distance covered in a frame at its speed [m].
        parking
            It starts or ends parking.
        """
        before = self._previous.get(name)
        if before is not None:
            moved = math.dist(centre, before[1]) if parking else math.dist(front, before[0])
            if moved > travelled + (PARKING_DISTANCE if parking else TELEPORT_DISTANCE):
                skipped_s = (moved - travelled) / max(travelled / self._dt, WALKING_SPEED)
                if parking or skipped_s > SKIPPED_S or self._members[name].id == EGO_ID:
                    self.start_new_member(name)
                else:
                    self.start_new_stretch(name)
        self._current[name] = front, centre
        return self._members[name]


class ParkingManoeuvres:
    """Tracker of vehicles that start or end parking. SUMO announces this up to a step before it moves them.

    Parameters
    ----------
    simulation
        libsumo's domain of the simulation.
    """

    def __init__(self, simulation: Any):
        self._simulation = simulation
        self._names: set[str] = set()

    def names(self, speeds: Callable[[str], float | None]) -> list[str]:
        """Return the vehicles that may be moved into or out of a parking space in this step.

        Parameters
        ----------
        speeds
            Returns the speed [m/s] of a nearby vehicle, None for others.
        """
        simulation = self._simulation
        self._names.update(simulation.getParkingStartingVehiclesIDList(), simulation.getParkingEndingVehiclesIDList())
        known = {name: speeds(name) for name in self._names}
        self._names = {name for name, speed in known.items() if speed is not None and speed < PARKING_SPEED}
        return sorted(self._names)
