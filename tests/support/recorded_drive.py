"""A drive as a real sensor would record it: an ego, one car, a planar LIDAR, and messages of ROS."""

from types import SimpleNamespace

import numpy as np
from support.optional import need

RATE_HZ, SCANS, BEAMS = 10.0, 30, 720
EGO_MPS, CAR_MPS = 5.0, 8.0
CAR_START, CAR_SIZE = (8.0, 3.0), (4.5, 1.8)
LASER_X = 1.0
START_S = 1000.0
"""Time of the first scan on the clock of the recording."""


def ego_pose(time):
    """x, y, yaw of the ego in the map, whose axes are turned by 90 degrees against the drive."""
    return np.array([20.0, -5.0 + EGO_MPS * (time - START_S), np.pi / 2])


def car_pose(time):
    """x, y, yaw of the car in the map: it drives ahead of the ego, 3 m to the left of it."""
    ahead = CAR_START[0] + CAR_MPS * (time - START_S)
    return np.array([20.0 - CAR_START[1], -5.0 + ahead, np.pi / 2])


def ranges(time):
    """(BEAMS,) ranges from the laser to the car; inf beside it."""
    angle = -np.pi + np.arange(BEAMS) * 2 * np.pi / BEAMS
    direction = np.column_stack([np.cos(angle), np.sin(angle)])
    centre = np.array([CAR_START[0] + (CAR_MPS - EGO_MPS) * (time - START_S) - LASER_X, CAR_START[1]])
    half = 0.5 * np.array(CAR_SIZE)
    with np.errstate(divide="ignore"):
        near, far = (centre - half) / direction, (centre + half) / direction
    enter, leave = np.minimum(near, far).max(axis=1), np.maximum(near, far).min(axis=1)
    return np.where((enter <= leave) & (enter > 0.0), enter, np.inf)


def times():
    return START_S + np.arange(SCANS) / RATE_HZ


def pose_times():
    return START_S - 0.1 + np.arange(int((SCANS / RATE_HZ + 0.3) * 50)) / 50.0


def quaternion(yaw):
    return SimpleNamespace(x=0.0, y=0.0, z=float(np.sin(yaw / 2)), w=float(np.cos(yaw / 2)))


def messages(types, power_on_s=0.0):
    """Yield topic, type, time [ns] and message of the drive, made with the message classes of a rosbags typestore.

    Stamps of the laser count from `power_on_s` on the clock of the recording.
    """
    header_of = types["std_msgs/msg/Header"]
    stamp_of = types["builtin_interfaces/msg/Time"]
    with_seq = "seq" in header_of.__dataclass_fields__

    def header(time, frame):
        stamp = stamp_of(sec=int(time), nanosec=round((time % 1.0) * 1e9))
        return header_of(**({"seq": 0} if with_seq else {}), stamp=stamp, frame_id=frame)

    def posed(time, frame, pose):
        point = types["geometry_msgs/msg/Point"](x=pose[0], y=pose[1], z=0.0)
        turn = types["geometry_msgs/msg/Quaternion"](**vars(quaternion(pose[2])))
        whole = types["geometry_msgs/msg/Pose"](position=point, orientation=turn)
        return types["geometry_msgs/msg/PoseStamped"](header=header(time, frame), pose=whole)

    kind, rows = "geometry_msgs/msg/PoseStamped", []
    for topic, pose in (("/ego", ego_pose), ("/car", car_pose)):
        rows += [(time, topic, kind, posed(time, "map", pose(time))) for time in pose_times()]
    for time in times():
        scan = types["sensor_msgs/msg/LaserScan"](
            header=header(time - power_on_s, "laser"),
            angle_min=-np.pi, angle_max=np.pi, angle_increment=2 * np.pi / BEAMS,
            time_increment=0.0, scan_time=0.1, range_min=0.1, range_max=80.0,
            ranges=ranges(time).astype(np.float32), intensities=np.empty(0, np.float32),
        )  # fmt: skip
        rows.append((time, "/scan", "sensor_msgs/msg/LaserScan", scan))
    for time, topic, kind, message in sorted(rows, key=lambda row: row[0]):
        yield topic, kind, round(time * 1e9), message


def write_ros1(path, power_on_s=0.0):
    """Write the drive as a ROS 1 bag."""
    need("recordings")
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    with Writer(path) as writer:
        connections = {}
        for topic, kind, time_ns, message in messages(store.types, power_on_s):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(connections[topic], time_ns, store.serialize_ros1(message, kind))
    return path


def write_ros2(path, plugin="SQLITE3", begin_s=-np.inf, end_s=np.inf):
    """Write the drive, or its part from `begin_s` until before `end_s` after its start, as a ROS 2 bag: a folder."""
    need("recordings")
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    with Writer(path, version=9, storage_plugin=StoragePlugin[plugin]) as writer:
        connections = {}
        for topic, kind, time_ns, message in messages(store.types):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            if begin_s <= 1e-9 * time_ns - START_S < end_s:
                writer.write(connections[topic], time_ns, store.serialize_cdr(message, kind))
    return path


OPTIONS = ("--mount", f"{LASER_X},0,0.5", "--odometry", "/ego", "--truth", f"/car={CAR_SIZE[0]},{CAR_SIZE[1]}")
"""Options of `luxloop import` for the drive."""
