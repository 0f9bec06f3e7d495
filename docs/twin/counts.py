"""Points on a labelled car, in a recording and on its simulated twin."""

import numpy as np
import numpy.typing as npt
from twin.labels import Car

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

MARGIN_M = 0.15
"""Margin around the labelled box, as for the vehicles of `realism`."""
LOWEST_M = 0.15
"""Lower points are ground."""
ABOVE_M = 0.20
"""Margin above the box's top."""
CUT_M = (0.45, 0.95)
"""Heights over the ground of the four-layer cut."""
LAYERS, STEP_DEG = 4, 0.5


def on_car(points_level: Floats, car: Car) -> Bools:
    """Return the (N,) mask of the points in the box of a car, with the margins."""
    ahead, left, up = car.in_box(points_level).T
    return np.asarray(
        (np.abs(ahead) <= car.length_m / 2 + MARGIN_M)
        & (np.abs(left) <= car.width_m / 2 + MARGIN_M)
        & (up >= LOWEST_M)
        & (up <= car.height_m + ABOVE_M)
    )


def height_bands(points_level: Floats, car: Car) -> tuple[int, int, int]:
    """Count the points on a car below 55 %, from 55 to 70 %, and above 70 % of its height.

    The lowest band is the body, the highest one mostly glass and roof.
    """
    share = car.in_box(points_level[on_car(points_level, car)])[:, 2] / car.height_m
    return int((share < 0.55).sum()), int(((share >= 0.55) & (share < 0.70)).sum()), int((share >= 0.70).sum())


def four_layers(points_level: Floats, ring: npt.NDArray[np.integer], car: Car) -> npt.NDArray[np.int64]:
    """Return the indices of a car's points in four rings, as a unit of four layers at bumper height sees it.

    Of the rings whose median height on the car is within `CUT_M`, four are chosen evenly, and of each ring one point
    per `STEP_DEG`. They are in the order of azimuth, left to right, ring by ring from below.
    """
    inside = np.flatnonzero(on_car(points_level, car))
    height = car.in_box(points_level)[:, 2]
    median = {number: float(np.median(height[inside[ring[inside] == number]])) for number in np.unique(ring[inside])}
    within = sorted((number for number in median if CUT_M[0] <= median[number] <= CUT_M[1]), key=lambda n: median[n])
    if len(within) > LAYERS:
        within = [within[round(k)] for k in np.linspace(0, len(within) - 1, LAYERS)]
    center = np.arctan2(car.y_m, car.x_m)
    azimuth = np.rad2deg(np.arctan2(points_level[:, 1], points_level[:, 0]) - center)
    azimuth = (azimuth + 180.0) % 360.0 - 180.0
    chosen = []
    for number in within:
        row = inside[ring[inside] == number]
        row = row[np.argsort(-azimuth[row], kind="stable")]
        _, first = np.unique(np.floor(-azimuth[row] / STEP_DEG), return_index=True)
        chosen.append(row[first])
    return np.concatenate(chosen) if chosen else np.empty(0, np.int64)
