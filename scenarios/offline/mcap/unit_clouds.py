"""Clouds of single units as ROS drivers publish them, and the static transforms to their frames.

Points lie as `velodyne_pcl::PointXYZIRT` of the Velodyne driver (ROS 2 branch): x, y, z at 0, 4 and 8, intensity at 16,
ring at 20, time at 24, 32 bytes per point. The time is relative to the stamp of the cloud.
"""

import re

import numpy as np
import scipy

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.offline.mcap.messages import BASE_LINK, EGO, Message, header, packed_cloud, vector
from luxloop.sensor_model.rig.beams import UnitTable
from luxloop.sensor_model.rig.rig import Mount, Rig
from luxloop.tracker.scan import Scan

LAYOUT = np.dtype(
    {
        "names": ["x", "y", "z", "intensity", "ring", "time"],
        "formats": ["<f4", "<f4", "<f4", "<f4", "<u2", "<f4"],
        "offsets": [0, 4, 8, 16, 20, 24],
        "itemsize": 32,
    }
)


def unit_frame(mount: Mount) -> str:
    """Return the name of the frame of a unit."""
    return f"lidar_{plain_name(mount)}"


def plain_name(mount: Mount) -> str:
    """Return the name of a unit without characters that ROS does not allow in topics."""
    return re.sub(r"\W", "_", mount.name)


def unit_cloud(time_ns: int, scan: Scan, unit: int, mount: Mount, units: UnitTable) -> Message:
    """Return the `sensor_msgs/PointCloud2` of a unit in its own frame; the echo pulse width [m] is the intensity."""
    rows = np.flatnonzero(scan.unit == unit)
    local = (scan.points_ego[rows].astype(np.float64) - units.origin_ego[unit]) @ units.R_ego_unit[unit]
    points = np.zeros(len(rows), LAYOUT)
    points["x"], points["y"], points["z"] = local.T
    points["intensity"], points["ring"] = scan.echo_pulse_width[rows], scan.layer[rows]
    points["time"] = scan.time_offset[rows]
    return packed_cloud(time_ns, unit_frame(mount), points)


def static_transforms(time_ns: int, rig: Rig, units: UnitTable) -> Message:
    """Return a `tf2_msgs/TFMessage` with the rear axle (on the ground) and the units in the ego frame."""
    rotations = scipy.spatial.transform.Rotation.from_matrix(units.R_ego_unit).as_quat()
    axle = _transform(time_ns, BASE_LINK, np.array([rig.rear_axle_x_m, 0.0, 0.0]), np.array([0.0, 0.0, 0.0, 1.0]))
    found = zip(rig.mounts, units.origin_ego, rotations, strict=True)
    return {"transforms": [axle, *(_transform(time_ns, unit_frame(mount), *pose) for mount, *pose in found)]}


def _transform(time_ns: int, child: str, origin: Floats, rotation: Floats) -> Message:
    turn = dict(zip("xyzw", rotation.tolist(), strict=True))
    pose = {"translation": vector(*origin.tolist()), "rotation": turn}
    return {"header": header(time_ns, EGO), "child_frame_id": child, "transform": pose}
