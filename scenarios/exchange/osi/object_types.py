"""Kinds of actors as OSI types of moving objects, and back."""

import betterosi as osi

from luxloop.scenarios.exchange.box_table import is_count
from luxloop.sim.world import Kind

KIND_REFERENCE = "luxloop.actor"
"""Type of the external reference with the name and the kind of an actor, since OSI has fewer types than kinds."""
POINTS_REFERENCE = "luxloop.points"
"""Type of the external reference with the number of LIDAR points on an actor, for which OSI has no field."""

_Vehicle = osi.MovingObject.VehicleClassification.Type
_VEHICLES = {
    Kind.CAR: _Vehicle.CAR, Kind.SUV: _Vehicle.CAR, Kind.VAN: _Vehicle.DELIVERY_VAN, Kind.TRUCK: _Vehicle.HEAVY_TRUCK,
    Kind.TRAILER_TRUCK: _Vehicle.HEAVY_TRUCK, Kind.BUS: _Vehicle.BUS, Kind.MOTORCYCLE: _Vehicle.MOTORBIKE,
    Kind.BICYCLE: _Vehicle.BICYCLE,
}  # fmt: skip
_KINDS = {vehicle: kind for kind, vehicle in reversed(_VEHICLES.items())}
"""The first kind of each type."""


def set_type(moving: osi.MovingObject, kind: Kind, name: str) -> None:
    """Set type, class and external reference of an actor."""
    types = osi.MovingObject.Type
    moving.type = {Kind.PEDESTRIAN: types.PEDESTRIAN, Kind.OBSTACLE: types.OTHER}.get(kind, types.VEHICLE)
    if kind in _VEHICLES:
        moving.vehicle_classification = osi.MovingObject.VehicleClassification(type=_VEHICLES[kind])
    moving.source_reference = [osi.ExternalReference(type=KIND_REFERENCE, identifier=[name, kind.name.lower()])]


def kind_name(moving: osi.MovingObject) -> str:
    """Return the kind of a moving object in lower case, by its external reference or else by its OSI type."""
    for reference in moving.source_reference:
        if reference.type == KIND_REFERENCE and len(reference.identifier) > 1:
            return str(reference.identifier[1])
    if moving.vehicle_classification is not None:
        vehicle = moving.vehicle_classification.type
        return _KINDS[vehicle].name.lower() if vehicle in _KINDS else str(vehicle.name).lower()
    return str(moving.type.name).lower()


def set_points(moving: osi.MovingObject, points: int) -> None:
    """Add the number of LIDAR points to the external references."""
    moving.source_reference.append(osi.ExternalReference(type=POINTS_REFERENCE, identifier=[str(points)]))


def points(moving: osi.MovingObject) -> int | None:
    """Return the number of LIDAR points; None without the reference, or with another text in it."""
    for reference in moving.source_reference:
        if reference.type == POINTS_REFERENCE and reference.identifier and is_count(reference.identifier[0]):
            return int(reference.identifier[0])
    return None
