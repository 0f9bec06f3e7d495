"""Export of a run as a multi-channel OSI trace, an MCAP file.

| topic | message | content |
|---|---|---|
| `ground_truth` | `osi3.GroundTruth` | ego, actors and obstacles in the world frame |
| `lidar/UNIT` | `osi3.SensorData` | points of a unit as measured |
| `truth/lidar/UNIT` | `osi3.SensorData` | the same points with true ranges and object ids |
| `tracks` | `osi3.SensorData` | confirmed tracks in the ego frame |
| `tracks/world` | `osi3.TrafficUpdate` | confirmed tracks in the world frame |

Metadata, schemas and channels are those of ASAM OSI 3.8, OSI trace file formats, multi channel trace file format. Times
start at 0, as in the run; the file does not depend on the time of writing.

The vehicle frame of OSI has its origin at the rear axle. Here it lies on the ground below the axle of the rig file,
because the simulation has no wheel radius.

A detection has no time, echo number or flags of its own: the clutter flag becomes the class CLUTTER, the ground flag
OVERDRIVABLE. The beam id is the layer. Elevations are rotations about y by the right-hand rule, so that a positive one
looks down (osi3.Spherical3d).

Tracks are in these frames:

| message | frame of reference | velocity |
|---|---|---|
| `osi3.SensorData` | virtual sensor at the ego's box centre on the ground | relative to it, as OSI defines it |
| `osi3.TrafficUpdate`, one per track | world | over ground, exactly as in the table of the run |
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import betterosi as osi
import numpy as np
import pandas as pd

from luxloop.arrays import Floats, Ints
from luxloop.scenarios.exchange.exported_run import confirmed_tracks
from luxloop.scenarios.exchange.osi.osi_values import (
    SOURCE,
    TRACKS,
    TRACKS_WORLD,
    TRUTH,
    identifier,
    moving_base,
    nanoseconds,
    orientation,
    set_points,
    set_type,
    timestamp,
    vector,
    version,
)
from luxloop.scenarios.grading.frame_truth import points_of_actors
from luxloop.scenarios.grading.plane_geometry import into_frame, turned
from luxloop.scenarios.offline.recorded_scans import TRACK_HEIGHT_M, RecordedRun
from luxloop.sensor_model.rig.beams import UnitTable, unit_table
from luxloop.sensor_model.rig.rig import Mount
from luxloop.sensor_model.truth import NO_ACTOR, ScanTruth
from luxloop.sim.world import Actors, Ego, Kind, Obstacles, WorldFrame
from luxloop.tracker.scan import PointFlag, Scan

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


FIRST_UNIT = 1
"""Sensor id of the first unit; 0 is the tracker."""
NO_OBJECT = 2**64 - 1
"""Id of detections of no object, as OSI defines it."""


def measured(frame: WorldFrame, scan: Scan, unit: int, mount: Mount, units: UnitTable) -> osi.SensorData:
    """Return the points of a unit as measured, with echo pulse width [m]; they have no object ids."""
    rows = np.flatnonzero(scan.unit == unit)
    spherical = _spherical(scan, rows, unit, units)
    columns = zip(
        spherical, scan.layer[rows].tolist(), scan.echo_pulse_width[rows].tolist(), scan.flags[rows].tolist(),
        strict=True,
    )  # fmt: skip
    detections = [
        osi.LidarDetection(
            position=_position(row), beam_id=identifier(layer), echo_pulse_width=width, classification=_class(flags)
        )
        for row, layer, width, flags in columns
    ]
    return _sensor_data(frame, unit, mount, detections)


def true(frame: WorldFrame, scan: Scan, truth: ScanTruth, unit: int, mount: Mount, units: UnitTable) -> osi.SensorData:
    """Return the same detections in the same order, with the range without noise and the id of the true object."""
    rows = np.flatnonzero(scan.unit == unit)
    spherical = _spherical(scan, rows, unit, units)
    spherical[:, 0] = truth.true_range[rows]
    columns = zip(spherical, scan.layer[rows].tolist(), truth.actor_id[rows].tolist(), strict=True)
    detections = [
        osi.LidarDetection(
            position=_position(row),
            beam_id=identifier(layer),
            object_id=identifier(NO_OBJECT if actor == NO_ACTOR else actor),
        )
        for row, layer, actor in columns
    ]
    return _sensor_data(frame, unit, mount, detections)


def _sensor_data(
    frame: WorldFrame, unit: int, mount: Mount, detections: Sequence[osi.LidarDetection]
) -> osi.SensorData:
    time, sensor, at = timestamp(frame.time), identifier(FIRST_UNIT + unit), _mounting(mount)
    header = osi.SensorDetectionHeader(
        measurement_time=time,
        cycle_counter=frame.index,
        mounting_position=at,
        sensor_id=sensor,
        data_qualifier=osi.SensorDetectionHeader.DataQualifier.AVAILABLE,
        number_of_valid_detections=len(detections),
    )
    lidar = osi.LidarDetectionData(header=header, detection=list(detections))
    return osi.SensorData(
        version=version(),
        timestamp=time,
        last_measurement_time=time,
        sensor_id=sensor,
        mounting_position=at,
        feature_data=osi.FeatureData(version=version(), lidar_sensor=[lidar]),
    )


def _mounting(mount: Mount) -> osi.MountingPosition:
    """Return the pose in the vehicle frame; rig files use the same frame and the same angles."""
    angles = np.deg2rad([mount.yaw_deg, mount.pitch_deg, mount.roll_deg])
    return osi.MountingPosition(position=vector(mount.x_m, mount.y_m, mount.z_m), orientation=orientation(*angles))


def _spherical(scan: Scan, rows: Ints, unit: int, units: UnitTable) -> Floats:
    """(N, 3) distance [m], azimuth and elevation [rad] of points in the frame of their unit."""
    points = (scan.points_ego[rows].astype(np.float64) - units.origin_ego[unit]) @ units.R_ego_unit[unit]
    x, y, z = points.T
    return np.column_stack([np.linalg.norm(points, axis=1), np.arctan2(y, x), -np.arctan2(z, np.hypot(x, y))])


def _position(row: Floats) -> osi.Spherical3d:
    distance, azimuth, elevation = row.tolist()
    return osi.Spherical3d(distance=distance, azimuth=azimuth, elevation=elevation)


def _class(flags: int) -> osi.DetectionClassification:
    if flags & PointFlag.CLUTTER:
        return osi.DetectionClassification.CLUTTER
    return osi.DetectionClassification.OVERDRIVABLE if flags & PointFlag.GROUND else osi.DetectionClassification.UNKNOWN


TRACKER = 0
"""Sensor id of the tracker."""


def sensor_data(frame: WorldFrame, tracks: pd.DataFrame, rear_axle_x_m: float) -> osi.SensorData:
    """Return all tracks of a frame as detected moving objects.

    Parameters
    ----------
    frame
        The frame.
    tracks
        Confirmed rows of the frame of the table of tracks.
    rear_axle_x_m
        Position of the rear axle of the ego, from its box centre [m].
    """
    time = timestamp(frame.time)
    header = osi.DetectedEntityHeader(
        measurement_time=time,
        cycle_counter=frame.index,
        data_qualifier=osi.DetectedEntityHeader.DataQualifier.AVAILABLE,
    )
    box_center = osi.MountingPosition(position=vector(-rear_axle_x_m, 0.0), orientation=orientation(0.0))
    return osi.SensorData(
        version=version(),
        timestamp=time,
        last_measurement_time=time,
        sensor_id=identifier(TRACKER),
        mounting_position=box_center,
        moving_object_header=header,
        moving_object=_detected(frame.ego, tracks),
    )


def traffic_updates(frame: WorldFrame, tracks: pd.DataFrame) -> list[osi.TrafficUpdate]:
    """Return a message for each track of a frame, in the world frame."""
    found = []
    for track in tracks.itertuples():
        pose = (track.x_world_m, track.y_world_m, track.yaw_world_rad)
        base = moving_base(pose, _size(track), np.array([track.vx_world_mps, track.vy_world_mps]))
        moving = osi.MovingObject(id=identifier(track.track_id), base=base)
        found.append(osi.TrafficUpdate(version=version(), timestamp=timestamp(frame.time), update=[moving]))
    return found


def relative_velocity(velocity_world: Floats, position_ego: Floats, ego: Ego) -> Floats:
    """(N, 2) velocity in the moving and turning ego frame of objects at (N, 2) [m/s]: R^T (v - v_ego) - w x p."""
    swept = ego.yaw_rate * np.column_stack([-position_ego[:, 1], position_ego[:, 0]])
    found: Floats = turned(velocity_world - ego.velocity_world, -ego.pose_world[2]) - swept
    return found


def _detected(ego: Ego, tracks: pd.DataFrame) -> list[osi.DetectedMovingObject]:
    pose_world = tracks[["x_world_m", "y_world_m", "yaw_world_rad"]].to_numpy(np.float64)
    pose_ego = into_frame(pose_world, ego.pose_world)
    velocity = relative_velocity(tracks[["vx_world_mps", "vy_world_mps"]].to_numpy(np.float64), pose_ego[:, :2], ego)
    return [
        osi.DetectedMovingObject(
            header=osi.DetectedItemHeader(tracking_id=identifier(track.track_id)),
            base=moving_base(pose_ego[t], _size(track), velocity[t]),
        )
        for t, track in enumerate(tracks.itertuples())
    ]


def _size(track: object) -> tuple[float, float, float]:
    return track.length_m, track.width_m, TRACK_HEIGHT_M  # type: ignore[attr-defined]


TRACE = "trace.mcap"
START = "1970-01-01T00:00:00Z"
"""Calendar time of time 0 of the simulation."""


class Sent(NamedTuple):
    """A message and its channel."""

    topic: str
    message: osi.GroundTruth | osi.SensorData | osi.TrafficUpdate
    description: str


def export(run: RecordedRun, folder: Path) -> None:
    """Write all frames of a run into a trace in an empty folder."""
    result = run.result
    metadata = {
        "zero_time": START,
        "creation_time": START,  # in simulated time: the same run gives the same file
        "description": f"{result.scenario}, seed {result.seed}: {result.config['description']}",
        "data_sources": f"{SOURCE} {result.versions.get('luxloop')}",
    }
    with osi.Writer(folder / TRACE, metadata=metadata, library=SOURCE) as writer:
        for time_ns, sent in _messages(run):
            writer.add(sent.message, sent.topic, time_ns, channel_description=sent.description)


def _messages(run: RecordedRun) -> Iterator[tuple[int, Sent]]:
    scans = run.scans()
    obstacles, units, axle = stationary_objects(scans.obstacles()), unit_table(run.rig), run.rig.rear_axle_x_m
    tracks, none = confirmed_tracks(run), run.result.tables["tracks"].iloc[:0]
    for frame, scan, truth in scans:
        time_ns, found = nanoseconds(frame.time), tracks.get(frame.index, none)
        points = points_of_actors(truth.actor_id, frame.actors.id)
        yield time_ns, Sent(TRUTH, ground_truth(frame, points, axle, obstacles), "truth in the world frame")
        for unit, mount in enumerate(run.rig.mounts):
            seen = measured(frame, scan, unit, mount, units)
            yield time_ns, Sent(f"lidar/{mount.name}", seen, "points as measured")
            known = true(frame, scan, truth, unit, mount, units)
            yield time_ns, Sent(f"truth/lidar/{mount.name}", known, "the same points with true ranges and object ids")
        sent = sensor_data(frame, found, axle)
        yield time_ns, Sent(TRACKS, sent, "confirmed tracks in the ego frame")
        for update in traffic_updates(frame, found):
            yield time_ns, Sent(TRACKS_WORLD, update, "confirmed tracks in the world frame")
