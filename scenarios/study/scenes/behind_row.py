"""Scene: poles, a fence or foliage between the ego and a car, which flickers behind them."""

from typing import Literal

import numpy as np

from luxloop.scenarios.study.scenes.scene_parts import (
    AFTER_S,
    BEFORE_S,
    MEMORY_S,
    OCCLUDER_Y_M,
    START,
    WALL_HEIGHT_M,
    Json,
    car,
    motion_table,
)
from luxloop.sim.scripted.motions import Straight

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
