"""Reader of true boxes and tracks in MCAP files: those of `luxloop mcap`, and objects of Autoware or vision_msgs."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from luxloop.arrays import Ints
from luxloop.scenarios.errors import TracksError
from luxloop.scenarios.exchange.box_table import ANY_AXES, BoxTable, checked, is_count
from luxloop.scenarios.exchange.file_formats import Role
from luxloop.scenarios.exchange.tabular_boxes import CONFIRMED
from luxloop.scenarios.offline.mcap.boxes import DETECTIONS, OBJECTS, FoundBox, read_boxes, topic_types
from luxloop.scenarios.offline.mcap.objects import POINTS

TOPICS: dict[Role, str] = {"truth": "/truth/boxes", "tracks": "/tracks"}
"""Topics of `luxloop mcap`."""
AXES = {"ego": "ego", "map": "world", "world": "world"}
"""Frames of reference by the id in the header of a message."""


def read(path: Path, role: Role) -> list[BoxTable]:
    """Return the boxes of the actors, or the confirmed tracks, once for each frame of reference that they have.

    Raises
    ------
    TracksError
        The file cannot be read, or has no topic of the role.
    """
    types = topic_types(path)
    if TOPICS[role] in types:
        return _own_boxes(path, role)
    topic = _other_topic(path, role, types)
    rows = read_boxes(path, topic)
    return [_others(path, role, topic, rows)]


def _own_boxes(path: Path, role: Role) -> list[BoxTable]:
    """Return boxes of luxloop in the world frame, if the version that wrote them did, and in the true ego frame."""
    topic = TOPICS[role]
    rows = [row for row in read_boxes(path, topic) if row.metadata.get("status", CONFIRMED) == CONFIRMED]
    kinds = [row.metadata.get("kind", "") for row in rows] if role == "truth" else None
    number = [row.frame for row in rows]
    ego = _table(path, topic, "ego", rows, frame=number, kinds=kinds)
    world = [
        row._replace(pose=row.pose_world, velocity=row.velocity_world) for row in rows if row.pose_world is not None
    ]
    return [_table(path, topic, "world", world, frame=number, kinds=kinds), ego] if len(world) == len(rows) else [ego]


def _others(path: Path, role: Role, topic: str, rows: list[FoundBox]) -> BoxTable:
    """Return boxes of another program, which have times, but no numbers of frames."""
    axes = {AXES.get(row.frame_id, ANY_AXES) for row in rows}
    if len(axes) > 1:
        raise TracksError(f"{path}: topic {topic}: its messages have several frames of reference; give one")
    table = _table(path, topic, next(iter(axes), ANY_AXES), rows, frame=None, kinds=[row.kind for row in rows])
    score = np.array([row.score for row in rows], np.float64)
    return replace(table, score=score) if role == "tracks" and np.isfinite(score).all() else table


def _other_topic(path: Path, role: Role, types: dict[str, str]) -> str:
    """Return the topic of objects of a role; objects with motion are preferred."""
    for wanted in (OBJECTS, DETECTIONS):
        found = [topic for topic, kind in types.items() if kind == wanted and ("truth" in topic) == (role == "truth")]
        if len(found) > 1:
            raise TracksError(f"{path}: has several topics of {role}: {', '.join(sorted(found))}; keep one of them")
        if found:
            return found[0]
    names = ", ".join(sorted(types))[:300] or "none"
    raise TracksError(f"{path}: no topic {TOPICS[role]}, and no other of {OBJECTS} or {DETECTIONS}; found {names}")


def _table(
    path: Path, topic: str, axes: str, rows: list[FoundBox], *, frame: list[int] | None, kinds: list[str] | None
) -> BoxTable:
    velocity = np.array([row.velocity for row in rows], np.float64).reshape(-1, 2)
    table = BoxTable(
        source=path,
        axes=axes,
        id=np.array([row.id for row in rows], np.str_),
        boxes=np.array([(*row.pose, *row.size[:2]) for row in rows], np.float64).reshape(-1, 5),
        frame=None if frame is None else np.array(frame, np.int64),
        time_s=np.array([row.time_s for row in rows], np.float64),
        velocity=velocity if np.isfinite(velocity).any() else None,
        height_m=np.array([row.size[2] for row in rows], np.float64),
        points=_points(path, rows) if kinds is not None else None,
        kind=None if kinds is None else np.array(kinds, np.str_),
    )
    return checked(table, lambda row: f"{topic}, time {rows[row].time_s:g} s, {rows[row].id}")


def _points(path: Path, rows: list[FoundBox]) -> Ints | None:
    """(N,) numbers of LIDAR points; None if a box has none, as those of other programs and of earlier versions."""
    if not all(POINTS in row.metadata for row in rows):
        return None
    for row in rows:
        if not is_count(row.metadata[POINTS]):
            raise TracksError(f"{path}: {row.id}, {POINTS}: {row.metadata[POINTS]:.60}: should be a number of points")
    return np.array([int(row.metadata[POINTS]) for row in rows], np.int64)
