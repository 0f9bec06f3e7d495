"""Vehicles of some traffic at one instant."""

from dataclasses import dataclass

from luxloop.arrays import Floats, Ints


@dataclass(frozen=True, slots=True)
class Body:
    """Constant properties of a vehicle."""

    name: str
    """The simulator's id."""
    vehicle_class: str
    """The simulator's word for its class."""
    size: tuple[float, float]
    """Length, width [m]."""
    graded: bool
    """It counts as a neighbour: bicycles and people do not, since they are not graded."""
    rejected: bool = False
    """It cannot carry the rig."""


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """All vehicles on the road at one instant, N rows."""

    time: float
    """[s] on the simulator's clock."""
    new: list[Body]
    """Vehicles that appear for the first time, in the order of their numbers."""
    body: Ints
    """(N,) number of each vehicle, counted from 0 in the order of first appearance."""
    pose: Floats
    """(N, 3) box centre x [m], y [m], yaw [rad] in the simulator's coordinates."""
    speed: Floats
    """(N,) [m/s]."""
