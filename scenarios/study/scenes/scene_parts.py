"""Parts of staged scenes as tables of a scenario file: road users, moving screen, wall; and constants of all scenes."""

import math
from collections.abc import Sequence
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from luxloop.scenarios.arrays import Floats
from luxloop.sensor_model.rig.rig import Rig, load_rig
from luxloop.sim.scripted.motions import Motion

Json = dict[str, Any]
Size = tuple[float, float, float]

RIG = "srx_six_lux"
CAR_M: Size = (4.6, 1.8, 1.5)
"""[m] Length, width and height of the target vehicle."""
WALL_HEIGHT_M = 4.0

START = np.array([-6.0, 9.0, 0.0])
"""Start pose (x [m], y [m], yaw [rad]) of a car two lanes to the left of the ego: it shows its front and its side."""
OCCLUDER_Y_M = 4.0
"""[m] Lateral position of the wall or screen, in the ego frame."""
BEFORE_S, AFTER_S = 3.0, 3.5
"""[s] Time in view before and after the occlusion: enough to confirm a track, and to reacquire the car."""
MEMORY_S = 4.5
"""[s] `grading.memory_s`, above its default of 3 s: the time partly hidden adds to the time fully hidden."""


@cache
def scene_rig() -> Rig:
    """Return the rig that the scenes are built for; its files are read once."""
    return load_rig(RIG, Path())


def car(start: Floats, motions: Sequence[Motion]) -> Json:
    """Return the target vehicle, starting at a pose (3,); without motions it is stationary."""
    return road_user("car", "car", start, CAR_M, motions)


def screen(start: Floats, length_m: float, motions: Sequence[Motion]) -> Json:
    """Return a thin moving occluder, as high as a wall; it is not graded."""
    return road_user("screen", "obstacle", start, (length_m, 0.2, WALL_HEIGHT_M), motions)


def wall(corners_m: list[list[float]]) -> Json:
    """Return a thin stationary wall between two points."""
    return {"kind": "wall", "corners_m": corners_m, "height_m": WALL_HEIGHT_M}


def motion_table(motion: Motion) -> Json:
    """Return the table of a motion."""
    return {key: value for key, value in asdict(motion).items() if value is not None}


def road_user(name: str, kind: str, start: Floats, size_m: Size, motions: Sequence[Motion] = ()) -> Json:
    """Return an actor that starts at a pose (3,); without motions it is stationary."""
    place = {"x_m": float(start[0]), "y_m": float(start[1]), "yaw_deg": math.degrees(start[2])}
    drive = {"motion": [motion_table(motion) for motion in motions]} if motions else {}
    return {"name": name, "kind": kind, **place, "size_m": list(size_m), **drive}
