"""Basic OSI values: times, identifiers, vectors and bases of objects.

Angles of OSI are yaw about z, then pitch about the new y, then roll about the new x, all right-handed: a positive
pitch looks down, as in rig files.
"""

import betterosi as osi
import numpy as np

from luxloop.arrays import Floats
from luxloop.scenarios.exchange.box_table import is_count
from luxloop.sim.world import Kind

Triple = tuple[float, float, float]

SOURCE = "luxloop"
"""First word of the data sources that the metadata of exported traces name."""

TRUTH, TRACKS, TRACKS_WORLD = "ground_truth", "tracks", "tracks/world"
"""Topics of exported traces."""

_NANOSECONDS = 1_000_000_000


def nanoseconds(time_s: float) -> int:
    """Return a time [s] in integer nanoseconds."""
    return round(time_s * _NANOSECONDS)


def timestamp(time_s: float) -> osi.Timestamp:
    """Return a time of the run."""
    seconds, nanos = divmod(nanoseconds(time_s), _NANOSECONDS)
    return osi.Timestamp(seconds=seconds, nanos=nanos)


def time_of(stamp: osi.Timestamp) -> float:
    """Return the time of a stamp [s]."""
    return float((stamp.seconds * _NANOSECONDS + stamp.nanos) / _NANOSECONDS)


def version() -> osi.InterfaceVersion:
    """Return the version of OSI."""
    major, minor, patch = map(int, osi.DEFAULT_VERSION.split("."))
    return osi.InterfaceVersion(version_major=major, version_minor=minor, version_patch=patch)


def identifier(value: int) -> osi.Identifier:
    """Return an id."""
    return osi.Identifier(value=value)


def vector(x: float, y: float, z: float = 0.0) -> osi.Vector3d:
    """Return a vector."""
    return osi.Vector3d(x=float(x), y=float(y), z=float(z))


def orientation(yaw: float, pitch: float = 0.0, roll: float = 0.0) -> osi.Orientation3d:
    """Return an orientation or its rate."""
    return osi.Orientation3d(yaw=float(yaw), pitch=float(pitch), roll=float(roll))


def moving_base(pose: Floats | Triple, size: Floats | Triple, velocity: Floats) -> osi.BaseMoving:
    """Return the base of an object on the ground.

    Parameters
    ----------
    pose
        x [m], y [m], yaw [rad] of the box centre.
    size
        Length, width, height [m].
    velocity
        (2,) velocity [m/s], left out where it is not finite.
    """
    length, width, height = map(float, size)
    base = osi.BaseMoving(
        dimension=osi.Dimension3d(length=length, width=width, height=height),
        position=vector(pose[0], pose[1], 0.5 * height),
        orientation=orientation(pose[2]),
    )
    if np.isfinite(velocity).all():
        base.velocity = vector(*velocity)
    return base


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
