"""Basic OSI values: times, identifiers, vectors and bases of objects.

Angles of OSI are yaw about z, then pitch about the new y, then roll about the new x, all right-handed: a positive
pitch looks down, as in rig files.
"""

import betterosi as osi
import numpy as np

from luxloop.scenarios.arrays import Floats

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
