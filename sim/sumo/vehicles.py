"""SUMO's vehicles in the terms of the world: yaw, kind by shape, and which of them can carry the rig."""

import math
from typing import Any

from luxloop.sim.world import Kind


def yaw_of(angle: float) -> float:
    """Return the yaw in (-pi, pi] [rad], counter-clockwise from east, of an angle in degrees clockwise from north."""
    return math.pi - math.radians(90.0 + angle) % math.tau


KIND_BY_SHAPE = {
    "passenger": Kind.CAR,
    "passenger/van": Kind.VAN,
    "delivery": Kind.VAN,
    "emergency": Kind.VAN,
    "firebrigade": Kind.TRUCK,
    "army": Kind.TRUCK,
    "truck": Kind.TRUCK,
    "truck/semitrailer": Kind.TRAILER_TRUCK,
    "truck/trailer": Kind.TRAILER_TRUCK,
    "bus": Kind.BUS,
    "rail": Kind.BUS,
    "motorcycle": Kind.MOTORCYCLE,
    "moped": Kind.MOTORCYCLE,
    "scooter": Kind.BICYCLE,
    "bicycle": Kind.BICYCLE,
    "pedestrian": Kind.PEDESTRIAN,
    "container": Kind.OBSTACLE,
    "ship": Kind.OBSTACLE,
    "aircraft": Kind.OBSTACLE,
}
"""By SUMO's guiShape, or its part before the slash; other shapes (taxi, police, unknown) are cars."""

SUV_HEIGHT = 1.55
"""[m] SUMO has no SUV shape: a passenger car at least this high is one."""


def kind_of_shape(shape: str, height: float) -> Kind:
    """Return the kind of a vehicle with SUMO's guiShape `shape` and a height [m]."""
    kind = KIND_BY_SHAPE.get(shape, KIND_BY_SHAPE.get(shape.partition("/")[0], Kind.CAR))
    return Kind.SUV if kind is Kind.CAR and height >= SUV_HEIGHT else kind


REJECTED_CLASSES = frozenset(
    {
        "pedestrian", "wheelchair", "bicycle", "scooter", "moped", "motorcycle",
        "tram", "rail_urban", "rail", "rail_electric", "rail_fast", "subway", "cable_car",
        "ship", "container", "aircraft", "drone",
    }
)  # fmt: skip
"""SUMO's vehicle classes without room for a rig, or without a road."""

REJECTED_KINDS = frozenset({Kind.MOTORCYCLE, Kind.BICYCLE, Kind.PEDESTRIAN, Kind.OBSTACLE})
"""The same by shape, for types without a class."""

OFF_ROAD_M = -1e8
"""[m] SUMO reports -2^30 for road users that are not on the road."""


def is_rejected(vehicles: Any, name: str) -> bool:
    """Return True if a vehicle cannot carry the rig.

    Parameters
    ----------
    vehicles
        libsumo's domain of vehicles.
    name
        The vehicle's SUMO id.
    """
    shape = vehicles.getShapeClass(name)
    kind = kind_of_shape(shape, 0.0)
    return vehicles.getVehicleClass(name) in REJECTED_CLASSES or kind in REJECTED_KINDS or shape.startswith("rail")
