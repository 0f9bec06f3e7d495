"""Vehicles that can carry the rig."""

from typing import Any

from luxloop.sim.sumo.vehicle_kinds import kind_of_shape
from luxloop.sim.world import Kind

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
