"""Sizes of vehicle classes: prior probabilities of length and width."""

from typing import NamedTuple

import numpy as np

from luxloop.tracker.arrays import Floats

GRID_M: Floats = np.array(0.4 * 1.02 ** np.arange(200), dtype=np.float64)
"""(G,) lengths and widths that a vehicle may have [m]: 0.4 to 20.6, in steps of 2 %."""


class Sides(NamedTuple):
    """Range of a side of a vehicle class: a uniform distribution with soft ends."""

    low_m: float
    """Shortest [m]."""
    high_m: float
    """Longest [m]."""
    std_m: float
    """Standard deviation beyond either end [m]."""


class SizeClass(NamedTuple):
    """Share and sizes of a vehicle class."""

    share: float
    """Share of all vehicles."""
    length: Sides
    width: Sides


SIZE_CLASSES = (
    SizeClass(0.75, Sides(4.5, 4.5, 0.4), Sides(1.82, 1.82, 0.09)),
    SizeClass(0.07, Sides(4.8, 6.1, 0.05), Sides(2.0, 2.0, 0.07)),
    SizeClass(0.08, Sides(5.9, 12.4, 0.05), Sides(2.51, 2.51, 0.08)),
    SizeClass(0.05, Sides(15.0, 18.75, 0.05), Sides(2.55, 2.55, 0.06)),
    SizeClass(0.05, Sides(2.11, 2.11, 0.25), Sides(0.77, 0.77, 0.12)),
)
"""Cars, vans, lorries and buses, lorries with trailers, motorcycles with riders.

Motorcycles, and the width of lorries, are the mean labels of nuScenes (Caesar et al. 2020); cars are between those of
nuScenes, 4.62 by 1.95 m, and KITTI, 3.88 by 1.63 m (Geiger et al. 2012). The limits of lorries and buses are those of
Directive 96/53/EC: 12 m, 18.75 m with a trailer, 2.55 m wide. The shares are rough."""


def side_probabilities() -> tuple[Floats, Floats]:
    """Return the shares (C,) of the classes, and the probabilities (C, 2, G) of `GRID_M` for length and width."""
    share = np.array([each.share for each in SIZE_CLASSES])
    sides = np.array([[each.length, each.width] for each in SIZE_CLASSES])
    low, high, std = (side[..., None] for side in np.moveaxis(sides, 2, 0))
    beyond = np.maximum(low - GRID_M, 0.0) + np.maximum(GRID_M - high, 0.0)
    cell = np.exp(-0.5 * (beyond / std) ** 2) * GRID_M  # cells of a geometric grid are as wide as their place
    return share, np.asarray(cell / cell.sum(axis=2, keepdims=True))
