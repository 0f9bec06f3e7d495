"""Vehicles that are hidden for a while: by a wall, in a row, or because a unit fails."""

import math
from typing import Literal

import numpy as np

from luxloop.scenarios.study.scenes.scene_parts import (
    AFTER_S,
    BEFORE_S,
    CAR_M,
    MEMORY_S,
    OCCLUDER_Y_M,
    START,
    WALL_HEIGHT_M,
    Json,
    car,
    motion_table,
    outline,
    scene_rig,
    shadows_on_line,
    wall,
)
from luxloop.sim.scripted.motions import LaneChange, Motion, Straight, state_at

Manoeuvre = Literal["keeps speed", "brakes", "changes lane"]

LANE_M = 3.5
BRAKING_MPS2, SIDEWAYS_MPS2 = 2.0, 2.0
"""[m/s^2] Comfortable decelerations and lateral accelerations, as in ordinary traffic."""
DRIVING_JITTER = {"jitter_m": 0.25}
"""Random shift of the start positions by the seed, which varies the phase of the scans."""


def hidden_behind_wall(occlusion_s: float, speed_mps: float, manoeuvre: Manoeuvre = "keeps speed") -> Json:
    """Return a scene in which a wall hides a car that drives beside the ego at the same speed.

    The wall covers exactly the shadow of the car's box on the wall's line during the occlusion, as seen from all LIDARs
    whose field of view contains the box: none of them sees any part of it for `occlusion_s`, and no longer. A bowed car
    is hidden a scan or two longer. A braking one may then leave the side LIDAR's field of view a scan before the rear
    LIDAR sees it past the wall.

    Parameters
    ----------
    occlusion_s
        Time for which the car is completely hidden [s].
    speed_mps
        Speed of the ego, and of the car until it is hidden [m/s].
    manoeuvre
        Motion of the car while it is hidden: it keeps its speed; brakes with 2 m/s^2, down to half its speed at most;
        or changes to the lane farther away, as far as 2 m/s^2 of lateral acceleration allow in that time.

    Raises
    ------
    ValueError
        The manoeuvre is unknown, or a number is not positive.
    """
    if not (occlusion_s > 0 and speed_mps > 0):
        raise ValueError(f"occlusion_s = {occlusion_s:g} and speed_mps = {speed_mps:g} must be positive")
    rig, hidden = scene_rig(), _hidden_motions(occlusion_s, speed_mps, manoeuvre)
    vanishes = START + np.array([speed_mps * BEFORE_S, 0.0, 0.0])
    times_s = np.linspace(0.0, occlusion_s, 51)
    ego_x_m = speed_mps * (BEFORE_S + times_s)
    points = np.stack([outline(state_at(hidden, vanishes, time).pose, CAR_M) for time in times_s])
    points[..., 0] -= ego_x_m[:, None]
    reaches = ego_x_m[:, None] + shadows_on_line(rig, points, OCCLUDER_Y_M)
    left_m, right_m = float(np.min(reaches)), float(np.max(reaches))
    motions = [Straight("straight", speed_mps, duration_s=BEFORE_S), *hidden]
    return {
        "description": f"A car at {speed_mps:g} m/s {manoeuvre} while a wall hides it for {occlusion_s:g} s.",
        "duration_s": BEFORE_S + occlusion_s + AFTER_S,
        "traffic": {
            "kind": "scripted",
            **DRIVING_JITTER,
            "ego": {"motion": [motion_table(Straight("straight", speed_mps))]},
            "actor": [car(START, motions)],
            "obstacle": [wall([[left_m, OCCLUDER_Y_M], [right_m, OCCLUDER_Y_M]])],
        },
        "grading": {"memory_s": MEMORY_S},
    }


def _hidden_motions(occlusion_s: float, speed_mps: float, manoeuvre: str) -> list[Motion]:
    """Return the motions of the car from the time it is hidden."""
    if manoeuvre == "keeps speed":
        return [Straight("straight", speed_mps)]
    if manoeuvre == "brakes":
        braking_s = min(occlusion_s, 0.5 * speed_mps / BRAKING_MPS2)
        slow_mps = speed_mps - BRAKING_MPS2 * braking_s
        return [Straight("straight", speed_mps, -BRAKING_MPS2, braking_s), Straight("straight", slow_mps)]
    if manoeuvre == "changes lane":
        # The quintic y = d (10 s^3 - 15 s^4 + 6 s^5) has its largest acceleration, 10 / sqrt(3) d / T^2, at s = 0.21.
        offset_m = min(LANE_M, SIDEWAYS_MPS2 * occlusion_s**2 * math.sqrt(3.0) / 10.0)
        return [LaneChange("lane-change", speed_mps, offset_m, occlusion_s)]
    raise ValueError(f'manoeuvre = "{manoeuvre}": should be "keeps speed", "brakes" or "changes lane"')


NO_OTHER_OUTAGE_S = 1e9


def hidden_with_failed_unit(
    unit: str, occlusion_s: float, speed_mps: float = 10.0, manoeuvre: Manoeuvre = "keeps speed"
) -> Json:
    """Return the scene `hidden_behind_wall`, in which a unit fails one second before the car is hidden.

    The wall stays as long as with all units, so the car is hidden for the same time; it is lost earlier and reappears
    later if the failed unit would have seen it first.

    Parameters
    ----------
    unit
        Name of the unit in the rig, e.g. `side left`; `none` for the same scene without a failure.
    occlusion_s, speed_mps, manoeuvre
        As for `hidden_behind_wall`.

    Raises
    ------
    ValueError
        The rig has no such unit, or as for `hidden_behind_wall`.
    """
    scene = hidden_behind_wall(occlusion_s, speed_mps, manoeuvre)
    if unit == "none":
        return scene
    names = [mount.name for mount in scene_rig().mounts]
    if unit not in names:
        raise ValueError(f'unit = "{unit}": should be {", ".join(names)} or none')
    fixed = {"unit": unit, "from_s": BEFORE_S - 1.0, "to_s": NO_OTHER_OUTAGE_S}
    outage = {"enabled": True, "mean_uptime_s": NO_OTHER_OUTAGE_S, "fixed": [fixed]}
    return {**scene, "noise": {"outage": outage}}


RowKind = Literal["poles", "fence", "foliage"]

PITCH_M: dict[str, float] = {"poles": 3.0, "fence": 0.15, "foliage": 0.8}
"""[m] Mean distance of poles, pickets and clumps of leaves from one to the next."""
HEIGHT_M: dict[str, float] = {"poles": WALL_HEIGHT_M, "fence": 1.8, "foliage": WALL_HEIGHT_M}
FOLIAGE_SEED = 1
"""Fixed, so that all seeds of a study pass the same leaves."""
FOLIAGE_REFLECTIVITY = 0.5
"""Diffuse reflectivity of leaves at 905 nm; they are brighter than in visible light."""
JITTER = {"jitter_m": 0.25}


def behind_row(kind: RowKind, cover: float, occlusion_s: float = 2.0, speed_mps: float = 10.0) -> Json:
    """Return a scene in which ego and car drive side by side, with a row of narrow occluders in between for a while.

    Every piece of the row is thin, parallel to the road, and as wide as `cover` times the distance to the next one, so
    that this share of the rays to the car is blocked at any angle.

    Parameters
    ----------
    kind
        Poles 3 m apart, pickets of a fence 15 cm apart, or clumps of leaves, whose widths and gaps vary about their
        means of 0.8 m per clump and gap.
    cover
        Share of the row that is covered, 0 to 1.
    occlusion_s
        Time for which the ego drives along the row [s].
    speed_mps
        Speed of both [m/s].

    Raises
    ------
    ValueError
        The kind is unknown, the cover is not between 0 and 1, or a time or speed is not positive.
    """
    if kind not in PITCH_M:
        raise ValueError(f'kind = "{kind}": should be {", ".join(PITCH_M)}')
    if not (0.0 < cover < 1.0 and occlusion_s > 0 and speed_mps > 0):
        raise ValueError(
            f"cover = {cover:g} must be between 0 and 1, occlusion_s = {occlusion_s:g} and speed_mps = {speed_mps:g} "
            "positive"
        )
    first_m = speed_mps * BEFORE_S + START[0]
    last_m = first_m + speed_mps * occlusion_s
    driving = Straight("straight", speed_mps)
    return {
        "description": f"A car behind {kind} that cover {cover:.0%} of a row, for {occlusion_s:g} s.",
        "duration_s": BEFORE_S + occlusion_s + AFTER_S,
        "traffic": {
            "kind": "scripted",
            **JITTER,
            "ego": {"motion": [motion_table(driving)]},
            "actor": [car(START, [driving])],
            "obstacle": [_piece(kind, left, right) for left, right in _pieces(kind, cover, first_m, last_m)],
        },
        "grading": {"memory_s": MEMORY_S},
    }


def _pieces(kind: RowKind, cover: float, first_m: float, last_m: float) -> list[tuple[float, float]]:
    """Return both ends [m] of each piece of a row."""
    pitch = PITCH_M[kind]
    count = max(1, round((last_m - first_m) / pitch))
    if kind != "foliage":
        left = first_m + pitch * np.arange(count)
        return list(zip(left.tolist(), (left + cover * pitch).tolist(), strict=True))
    # Gamma-distributed widths and gaps with a coefficient of variation of 0.5.
    draws = np.random.default_rng(FOLIAGE_SEED).gamma(4.0, 0.25, (2, count))
    widths, gaps = draws / draws.mean(axis=1, keepdims=True) * pitch * np.array([[cover], [1.0 - cover]])
    left = first_m + np.cumsum(widths + gaps) - widths
    return list(zip(left.tolist(), (left + widths).tolist(), strict=True))


def _piece(kind: RowKind, left_m: float, right_m: float) -> Json:
    corners = [[left_m, OCCLUDER_Y_M], [right_m, OCCLUDER_Y_M]]
    leaves = {"reflectivity": FOLIAGE_REFLECTIVITY} if kind == "foliage" else {}
    return {"kind": "wall", "corners_m": corners, "height_m": HEIGHT_M[kind], **leaves}
