"""What staged scenes are put together of, as tables of a scenario file."""

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from scenarios.arrays import Floats
from sim.scripted.motions import Motion

Json = dict[str, Any]
Size = tuple[float, float, float]

CAR_M: Size = (4.6, 1.8, 1.5)
WALL_HEIGHT_M = 4.0


def car(start: Floats, motions: Sequence[Motion]) -> Json:
    """The car that all is about, at a pose (3,), with what it does; without motions it stands."""
    return _actor("car", "car", start, CAR_M, motions)


def screen(start: Floats, length_m: float, motions: Sequence[Motion]) -> Json:
    """Something thin, as high as a wall, that moves; nobody asks of a tracker that it follow it."""
    return _actor("screen", "obstacle", start, (length_m, 0.2, WALL_HEIGHT_M), motions)


def wall(corners_m: list[list[float]]) -> Json:
    """Something thin that stands between two places."""
    return {"kind": "wall", "corners_m": corners_m, "height_m": WALL_HEIGHT_M}


def motion_table(motion: Motion) -> Json:
    """One motion."""
    return {key: value for key, value in asdict(motion).items() if value is not None}


def _actor(name: str, kind: str, start: Floats, size_m: Size, motions: Sequence[Motion]) -> Json:
    place = {"x_m": float(start[0]), "y_m": float(start[1]), "yaw_deg": math.degrees(start[2])}
    drive = {"motion": [motion_table(motion) for motion in motions]} if motions else {}
    return {"name": name, "kind": kind, **place, "size_m": list(size_m), **drive}
