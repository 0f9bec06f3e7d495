"""`osi3.SensorData` of one LIDAR: its points as detections in its own frame, as measured or with their truth.

A detection has no time, echo number or flags of its own: the clutter flag becomes the class CLUTTER, the ground flag
OVERDRIVABLE. The beam id is the layer. Elevations are rotations about y by the right-hand rule, so that a positive one
looks down (osi3.Spherical3d).
"""

from collections.abc import Sequence

import betterosi as osi
import numpy as np

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.exchange.osi.base_values import identifier, orientation, timestamp, vector, version
from luxloop.sensor_model.rig.beams import UnitTable
from luxloop.sensor_model.rig.rig import Mount
from luxloop.sensor_model.truth import NO_ACTOR, ScanTruth
from luxloop.sim.world import WorldFrame
from luxloop.tracker.scan import PointFlag, Scan

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
