"""`osi3.GroundTruth` of a frame: the ego, the actors and the static obstacles, in the world frame.

The vehicle frame of OSI has its origin at the rear axle. Here it lies on the ground below the axle of the rig file,
because the simulation has no wheel radius.
"""

import betterosi as osi
import numpy as np

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.exchange.osi.base_values import identifier, moving_base, orientation, timestamp, vector, version
from luxloop.scenarios.exchange.osi.object_types import set_points, set_type
from luxloop.sim.world import Actors, Kind, Obstacles, WorldFrame

HOST_ID = 2**32
"""Id of the ego; ids of actors are smaller, those of obstacles follow."""


def ground_truth(
    frame: WorldFrame, points: Ints, rear_axle_x_m: float, stationary: list[osi.StationaryObject]
) -> osi.GroundTruth:
    """Return the message of a frame.

    Parameters
    ----------
    frame
        The frame.
    points
        (A,) number of LIDAR points on each actor.
    rear_axle_x_m
        Position of the rear axle of the ego, from its box centre [m].
    stationary
        Obstacles, from `stationary_objects`.
    """
    actors = [_actor(frame.actors, a, int(points[a])) for a in range(len(frame.actors))]
    return osi.GroundTruth(
        version=version(),
        timestamp=timestamp(frame.time),
        host_vehicle_id=identifier(HOST_ID),
        moving_object=[_host(frame, rear_axle_x_m), *actors],
        stationary_object=stationary,
    )


def stationary_objects(obstacles: Obstacles) -> list[osi.StationaryObject]:
    """Return obstacles: a wall of two points as a box along it, others as a polygon in a box along the world's axes."""
    found = []
    for m in range(len(obstacles)):
        corners = obstacles.vertices_world[obstacles.offset[m] : obstacles.offset[m + 1]]
        base = _wall(corners) if len(corners) < 3 else _building(corners)
        bottom, top = float(obstacles.base[m]), float(obstacles.height[m])
        base.dimension.height, base.position.z = top - bottom, 0.5 * (bottom + top)
        types = osi.StationaryObject.Classification.Type
        kind = types.WALL if len(corners) < 3 else types.BUILDING
        classification = osi.StationaryObject.Classification(type=kind)
        found.append(osi.StationaryObject(id=identifier(HOST_ID + 1 + m), base=base, classification=classification))
    return found


def _host(frame: WorldFrame, rear_axle_x_m: float) -> osi.MovingObject:
    ego = frame.ego
    host = osi.MovingObject(id=identifier(HOST_ID), base=moving_base(ego.pose_world, ego.size, ego.velocity_world))
    host.base.acceleration = vector(*ego.acceleration_world)
    host.base.orientation_rate = orientation(ego.yaw_rate)
    host.vehicle_attributes = osi.MovingObject.VehicleAttributes(
        bbcenter_to_rear=vector(rear_axle_x_m, 0.0, -0.5 * ego.size[2])
    )
    set_type(host, Kind.CAR, "ego")
    return host


def _actor(actors: Actors, a: int, points: int) -> osi.MovingObject:
    base = moving_base(actors.pose_world[a], actors.size[a], actors.velocity_world[a])
    base.acceleration = vector(*actors.acceleration_world[a])
    base.orientation_rate = orientation(actors.yaw_rate[a])
    moving = osi.MovingObject(id=identifier(int(actors.id[a])), base=base)
    set_type(moving, Kind(actors.kind[a]), str(actors.name[a]))
    set_points(moving, points)
    return moving


def _wall(corners: Floats) -> osi.BaseStationary:
    along, center = corners[-1] - corners[0], 0.5 * (corners[-1] + corners[0])
    return osi.BaseStationary(
        dimension=osi.Dimension3d(length=float(np.hypot(*along)), width=0.0),
        position=vector(*center),
        orientation=orientation(np.arctan2(along[1], along[0])),
    )


def _building(corners: Floats) -> osi.BaseStationary:
    """Return the box of a polygon; OSI's polygons run counter-clockwise and are relative to the centre."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    center = 0.5 * (low + high)
    x, y = (corners - center).T
    clockwise = np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) < 0.0
    outline = (corners - center)[::-1] if clockwise else corners - center
    length, width = (high - low).tolist()
    return osi.BaseStationary(
        dimension=osi.Dimension3d(length=length, width=width),
        position=vector(*center),
        orientation=orientation(0.0),
        base_polygon=[osi.Vector2d(x=float(px), y=float(py)) for px, py in outline],
    )
