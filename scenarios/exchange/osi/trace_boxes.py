"""Reader of true boxes and tracks in OSI traces (MCAP).

Truth is `osi3.GroundTruth` without its host vehicle, in the world frame, and in the ego frame where the host is given.
Tracks are `osi3.TrafficUpdate` in the world frame, and detected moving objects of `osi3.SensorData` in the ego frame:
the box centre of the host, on its heading. Numbers are not rounded: the file has float64. Frames of luxloop's own
traces have numbers, one per message `osi3.GroundTruth`; other traces have times only.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import betterosi as osi
import numpy as np

from luxloop.arrays import Floats, Ints
from luxloop.scenarios.errors import InputError, TracksError
from luxloop.scenarios.exchange.box_table import BoxTable, checked
from luxloop.scenarios.exchange.file_formats import Role
from luxloop.scenarios.exchange.osi.osi_values import SOURCE, TRACKS, TRACKS_WORLD, TRUTH, kind_name, points, time_of
from luxloop.scenarios.grading.plane_geometry import into_frame, out_of_frame, turned
from luxloop.scenarios.offline.mcap.chunks import require_chunks


def timed(path: Path, messages: Iterable[Any]) -> Iterator[tuple[float, Any]]:
    """Yield the time [s] of each message, and the message.

    Raises
    ------
    TracksError
        One has no time; messages of a type are counted from 1.
    """
    number: Counter[str] = Counter()
    for message in messages:
        name = type(message).__name__
        number[name] += 1
        if message.timestamp is None:
            raise TracksError(f"{path}: osi3.{name} {number[name]}: no timestamp; give each message its time")
        yield time_of(message.timestamp), message


def object_id(path: Path, time_s: float, identifier: osi.Identifier | None, field: str = "id") -> int:
    """Return the id of an object.

    Raises
    ------
    TracksError
        It has none.
    """
    if identifier is None:
        raise TracksError(f"{path}: time {time_s:g} s: an object without {field}; give each object an id")
    return int(identifier.value)


Box = tuple[float, float, float, float, float]


@dataclass(frozen=True, slots=True)
class Host:
    """Motion of the host vehicle."""

    id: int
    pose_world: Floats
    """(3,) x [m], y [m], yaw [rad] of its box centre."""
    velocity_world: Floats
    """(2,) [m/s]."""
    yaw_rate: float
    """[rad/s]."""
    rear_axle: tuple[float, float]
    """Origin of the vehicle frame, from the box centre [m]."""

    @classmethod
    def of(cls, truth: osi.GroundTruth) -> "Host | None":
        """Return the host vehicle of a message; None if it names none, or one that is not in it."""
        name = truth.host_vehicle_id
        moving = next((m for m in truth.moving_object if name is not None and m.id.value == name.value), None)
        if moving is None:
            return None
        base, attributes = moving.base, moving.vehicle_attributes
        axle = attributes.bbcenter_to_rear if attributes is not None else None
        return cls(
            id=name.value,
            pose_world=np.array([base.position.x, base.position.y, base.orientation.yaw]),
            velocity_world=np.array([base.velocity.x, base.velocity.y]) if base.velocity else np.zeros(2),
            yaw_rate=base.orientation_rate.yaw if base.orientation_rate else 0.0,
            rear_axle=(axle.x, axle.y) if axle is not None else (0.0, 0.0),
        )


@dataclass(frozen=True, slots=True)
class SensorFrame:
    """Pose of a virtual sensor in the ego frame, the box centre of the host."""

    pose_ego: Floats
    """(3,) x [m], y [m], yaw [rad]."""

    def place(self, box: Box) -> Box:
        """Return a box in the ego frame; unchanged, bit for bit, if the frames are the same."""
        if not self.pose_ego.any():
            return box
        x, y, heading = out_of_frame(np.array([box[:3]]), self.pose_ego)[0].tolist()
        return (x, y, heading, *box[3:])

    def turn(self, velocity: Floats) -> Floats:
        """Return a vector (2,) on the axes of the ego frame."""
        return turned(velocity, float(self.pose_ego[2]))


def sensor_frame(mounting: osi.MountingPosition | None, host: Host | None) -> SensorFrame:
    """Return the frame of a virtual sensor; its mounting position is relative to the rear axle of the host."""
    axle = np.array(host.rear_axle if host else (0.0, 0.0))
    at = mounting.position if mounting is not None else None
    yaw = mounting.orientation.yaw if mounting is not None and mounting.orientation is not None else 0.0
    offset = np.array([at.x, at.y]) if at is not None else np.zeros(2)
    return SensorFrame(np.array([*(axle + offset), yaw]))


def over_ground(velocity: Floats, position_ego: Floats, host: Host) -> Floats:
    """(2,) velocity over ground, on the axes of the ego frame, of an object that moves at `velocity` in that frame."""
    x, y = position_ego.tolist()
    swept = host.yaw_rate * np.array([-y, x])
    found: Floats = velocity + swept + turned(host.velocity_world, -float(host.pose_world[2]))
    return found


WORLD, EGO = "world", "ego"
UNKNOWN = np.full(2, np.nan)


class Found(NamedTuple):
    """Box of a message."""

    time_s: float
    id: int
    box: tuple[float, float, float, float, float]
    """x [m], y [m], heading [rad], length [m], width [m]."""
    velocity: Floats
    """(2,) over ground, on the axes of the box [m/s]; NaN where it is unknown."""
    height_m: float
    kind: str = ""
    points: int | None = None


def read(path: Path, role: Role) -> list[BoxTable]:
    """Return the boxes of a trace, once for each frame of reference that it has.

    Raises
    ------
    TracksError
        The file cannot be read, has no messages of the role, or a box is invalid.
    """
    try:
        require_chunks(path)
        own = any(record["data"].get("data_sources", "").startswith(SOURCE) for record in osi.read_file_metadata(path))
        found = _truth(path, own) if role == "truth" else _tracks(path, own)
        frames = _frame_times(path) if own else None
    except (InputError, MemoryError):
        raise
    except Exception as error:  # parsers of damaged files raise the errors of their libraries, such as struct.error
        reason = getattr(error, "strerror", None) or " ".join(str(error).split()) or type(error).__name__
        raise TracksError(f"{path}: cannot be read ({reason}); give an OSI trace in MCAP") from error
    if not found:
        wanted = "GroundTruth" if role == "truth" else "SensorData or TrafficUpdate"
        raise TracksError(f"{path}: has no message osi3.{wanted}; give a trace with one")
    return [_table(path, axes, found[axes], role, frames) for axes in (WORLD, EGO) if axes in found]


def _truth(path: Path, own: bool) -> Mapping[str, list[Found]]:
    world: list[Found] = []
    ego: list[Found] = []
    messages = located = 0
    found = osi.read(str(path), return_ground_truth=True, mcap_topics=[TRUTH] if own else None)
    for time_s, truth in timed(path, found):
        named = [(object_id(path, time_s, moving.id), moving) for moving in truth.moving_object]
        host = Host.of(truth)
        others = [(name, moving) for name, moving in named if host is None or name != host.id]
        rows = [
            _moving(time_s, name, moving.base)._replace(kind=kind_name(moving), points=points(moving))
            for name, moving in others
        ]
        world += rows
        ego += [_seen_from(row, host.pose_world) for row in rows] if host else []
        messages, located = messages + 1, located + bool(host)
    if not messages:
        return {}
    return {WORLD: world, EGO: ego} if located == messages else {WORLD: world}


def _tracks(path: Path, own: bool) -> Mapping[str, list[Found]]:
    tables: dict[str, list[Found]] = {}
    hosts: dict[int, Host] = {}
    for time_s, message in timed(path, _messages(path, own)):
        if isinstance(message, osi.GroundTruth):
            host = Host.of(message)
            hosts |= {round(1e9 * time_s): host} if host else {}
        elif isinstance(message, osi.TrafficUpdate):
            rows = tables.setdefault(WORLD, [])
            rows += [_moving(time_s, object_id(path, time_s, moving.id), moving.base) for moving in message.update]
        elif message.moving_object_header is not None or message.moving_object:
            now = hosts.get(round(1e9 * time_s))
            tables.setdefault(EGO, []).extend(_detected(path, time_s, message, now))
    return tables


def _messages(path: Path, own: bool) -> Iterator[Any]:
    """Yield messages with tracks and hosts; those of a trace of luxloop without its many detections."""
    wanted = osi.GroundTruth | osi.SensorData | osi.TrafficUpdate
    topics = [TRUTH, TRACKS, TRACKS_WORLD] if own else None
    return (message for message in osi.read(str(path), mcap_topics=topics) if isinstance(message, wanted))


def _detected(path: Path, time_s: float, message: osi.SensorData, host: Host | None) -> Iterator[Found]:
    """Yield detected objects in the ego frame, with velocities over ground if the host is known."""
    frame = sensor_frame(message.mounting_position, host)
    for item in message.moving_object:
        name = object_id(path, time_s, item.header and item.header.tracking_id, "header.tracking_id")
        row = _moving(time_s, name, item.base)
        box = frame.place(row.box)
        velocity = UNKNOWN if host is None else over_ground(frame.turn(row.velocity), np.array(box[:2]), host)
        yield row._replace(box=box, velocity=velocity)


def _moving(time_s: float, name: int, base: osi.BaseMoving | None) -> Found:
    if base is None or base.position is None or base.dimension is None:
        raise ValueError(f"time {time_s:g} s, object {name}: its base has no position or no dimension")
    at, size, turn = base.position, base.dimension, base.orientation
    velocity = UNKNOWN if base.velocity is None else np.array([base.velocity.x, base.velocity.y])
    yaw = 0.0 if turn is None else turn.yaw
    return Found(time_s, name, (at.x, at.y, yaw, size.length, size.width), velocity, size.height)


def _seen_from(row: Found, pose_world: Floats) -> Found:
    x, y, heading = into_frame(np.array([row.box[:3]]), pose_world)[0].tolist()
    return row._replace(box=(x, y, heading, *row.box[3:]), velocity=turned(row.velocity, -pose_world[2]))


def _frame_times(path: Path) -> Floats:
    """(F,) times of the frames of a trace of luxloop, which starts with frame 0 [s]."""
    return np.array([time_s for time_s, _ in timed(path, osi.read(str(path), mcap_topics=[TRUTH]))], np.float64)


def _table(path: Path, axes: str, rows: list[Found], role: Role, frames: Floats | None) -> BoxTable:
    velocity = np.array([row.velocity for row in rows], np.float64).reshape(-1, 2)
    time_s = np.array([row.time_s for row in rows], np.float64)
    table = BoxTable(
        source=path,
        axes=axes,
        id=np.array([str(row.id) for row in rows], np.str_),
        boxes=np.array([row.box for row in rows], np.float64).reshape(-1, 5),
        frame=None if frames is None else np.searchsorted(frames, time_s),
        time_s=time_s,
        velocity=velocity if np.isfinite(velocity).any() else None,
        height_m=np.array([row.height_m for row in rows], np.float64),
        points=_points(rows) if role == "truth" else None,
        kind=np.array([row.kind for row in rows], np.str_) if role == "truth" else None,
    )
    return checked(table, lambda row: f"time {rows[row].time_s:g} s, object {rows[row].id}")


def _points(rows: list[Found]) -> Ints | None:
    """(N,) numbers of LIDAR points; None if an object has none."""
    known = [row.points for row in rows if row.points is not None]
    return np.array(known, np.int64) if len(known) == len(rows) else None
