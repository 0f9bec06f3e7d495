"""Vehicle classes: their sizes, and what the visible sides of an object tell about them."""

from functools import cache
from typing import NamedTuple

import numpy as np

from luxloop import elementary, elementwise
from luxloop.arrays import Bools, Floats
from luxloop.compiled import kernel

FACE_MIN_M = 0.6
"""A side with a smaller visible extent may face away [m]; corners are rounded by 0.25 to 0.4."""

CAR_LONGEST_M = 6.0
"""Longest car [m]: longer vehicles are trucks and buses."""

WIDEST_M = 2.8
"""Width of a vehicle at most [m]: a truck measures 2.55, and the errors of two fits."""

WIDE_M = 3.0
"""A longer side is the length of a vehicle [m]; vehicles are narrower."""

LONGEST_M = 18.8
"""Length of a vehicle at most [m], a lorry with its trailer (Directive 96/53/EC)."""

FASTEST_MPS = 75.0
"""Speed of a vehicle over ground at most [m/s]: 270 km/h."""

TRUNCATED_PROBABILITY = 0.3
"""Probability that a side that seems whole is truncated: thin occluders and lost beams are not detected."""

GRID_M: Floats = np.cumprod(np.array([0.4, *199 * [1.02]]))
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


@cache
def side_probabilities() -> tuple[Floats, Floats]:
    """Return the shares (C,) of the classes, and the probabilities (C, 2, G) of `GRID_M` for length and width.

    They are computed once, when a size is first estimated.
    """
    share = np.array([each.share for each in SIZE_CLASSES])
    sides = np.array([[each.length, each.width] for each in SIZE_CLASSES])
    low, high, std = (side[..., None] for side in np.moveaxis(sides, 2, 0))
    beyond = np.maximum(low - GRID_M, 0.0) + np.maximum(GRID_M - high, 0.0)
    cell = elementwise.exp(-0.5 * (beyond / std) ** 2) * GRID_M  # cells of a geometric grid are as wide as their place
    return share, np.asarray(cell / cell.sum(axis=2, keepdims=True))


LINE_DEPTH_M = 0.015
"""Mean depth of points on a line, from range noise [m]."""

CAR_LINE_FRACTION = 0.1
"""Share of the single faces of cars whose points lie on a line."""

CAR_DEPTH_M = 0.22
"""Most frequent depth of the other ones [m], which have a gamma distribution of shape 2: parts of the bow and of glass
that is set back are seen."""

LORRY_LINE_FRACTION = 0.5
"""Share of the single faces of lorries whose points lie on a line; the rest has a small relief."""

LORRY_RELIEF_M = 0.15
"""Mean relief of the other ones [m]."""

BACKGROUND_LINE_FRACTION = 0.55
"""Share of background segments whose points lie on a line."""

BACKGROUND_RELIEF_FRACTION = 0.35
"""Share of background segments with a small relief; the rest has a corner."""

BACKGROUND_RELIEF_M = 0.15
"""Mean relief of these [m]."""

CORNER_DEPTH_MAX_M = 2.8
"""Depth of a background segment with a corner, at most [m]; deeper ones are no vehicles."""


@kernel()
def of_car(depth_m: float) -> float:
    """Return the density of the depth of a single face of a car, van or motorcycle."""
    bowed = depth_m / CAR_DEPTH_M * exponential(depth_m, CAR_DEPTH_M)
    return CAR_LINE_FRACTION * exponential(depth_m, LINE_DEPTH_M) + (1.0 - CAR_LINE_FRACTION) * bowed


@kernel()
def of_lorry(depth_m: float) -> float:
    """Return the density of the depth of a single face of a lorry or bus."""
    line, relief = exponential(depth_m, LINE_DEPTH_M), exponential(depth_m, LORRY_RELIEF_M)
    return LORRY_LINE_FRACTION * line + (1.0 - LORRY_LINE_FRACTION) * relief


@kernel()
def of_background(depth_m: float) -> float:
    """Return the density of the depth of a background segment; deeper ones than vehicles are as dense as corners."""
    line, relief = exponential(depth_m, LINE_DEPTH_M), exponential(depth_m, BACKGROUND_RELIEF_M)
    corner_share = 1.0 - BACKGROUND_LINE_FRACTION - BACKGROUND_RELIEF_FRACTION
    return (
        BACKGROUND_LINE_FRACTION * line + BACKGROUND_RELIEF_FRACTION * relief + corner_share / CORNER_DEPTH_MAX_M
    )  # fmt: skip


@kernel()
def exponential(depth_m: float, mean_m: float) -> float:
    """Return the density of an exponential distribution."""
    return elementary.exp(-depth_m / mean_m) / mean_m


class VehicleClass(NamedTuple):
    """Range of sizes of a vehicle class, with a uniform distribution."""

    share: float
    """Share of all vehicles."""
    length_m: tuple[float, float]
    """Shortest and longest [m]."""
    width_m: tuple[float, float]
    """Narrowest and widest without mirrors [m]."""
    end_fraction: float
    """Share of the views that show one end and no side."""
    side_fraction: float
    """Share of the views that show one side and no end."""
    flat: bool
    """True if single faces are as flat as those of lorries, False if bowed as those of cars."""


CLASSES = (
    VehicleClass(0.60, (3.4, 5.3), (1.5, 2.15), 0.17, 0.14, False),
    VehicleClass(0.10, (5.1, 6.3), (1.85, 2.25), 0.17, 0.14, False),
    VehicleClass(0.25, (5.1, 18.9), (2.1, 2.75), 0.28, 0.22, True),
    VehicleClass(0.05, (1.8, 2.6), (0.5, 1.1), 0.2, 0.2, False),
)
"""Cars; vans and pickups, of which 5.9 by 2.0 m are usual; lorries and buses up to the limits of Directive 96/53/EC
(18.75 m and 2.6 m); motorcycles. All ranges are wider by 0.1 to 0.15 m, the errors of visible extents. The shares of
the classes are rough. Those of single faces are of the boxes that the rig sees in 24 runs of the catalog, 30 000 of
cars and vans and 3000 of lorries; motorcycles have too few to tell."""

PAIR = VehicleClass(0.25, (7.0, 12.0), (1.5, 2.15), 0.2, 0.2, True)
"""Two cars in a row that form one segment: as long as a lorry, but no vehicle, and about as frequent."""

CAR_LENGTH_MAX_M = 5.3
"""Length of a car at most [m]: a shorter piece of a pair is one of both cars."""

ROUNDING_M = 0.4
"""Part of a side that rounded corners hide at most, both ends together [m]."""

BACKGROUND_LENGTH_M = (0.5, 20.0)
"""Lengths of background segments [m]; longer ones are removed as walls."""

OUTLIER_DENSITY = 1e-3
"""Density of sides of any other extent [1/m], which limits the evidence of one view."""

PIECE_LOG_ODDS_MAX = 1.0
"""Maximum log-odds of a lorry whose view has no untruncated side."""

Side = tuple[float, float]
"""Visible extent [m] of a side, and the probability that it is truncated."""


@kernel()
def length_log_odds(size: Floats, whole: Bools, visible_min_m: float, truncated_probability: float) -> float:
    """Return the log-odds that the first of two sides is the length of a vehicle, and the second one its width.

    The sides come from a mixture of `CLASSES`. A whole side shows its extent but for `ROUNDING_M`. A truncated side
    shows a piece of any shorter extent, all equally likely.

    Parameters
    ----------
    size
        (2,) visible extents [m].
    whole
        (2,) mask of sides that are truncated at neither end.
    visible_min_m
        A shorter side may face away, and contains no information [m].
    truncated_probability
        Probability that a side that seems whole is truncated by something that was not detected.
    """
    first = truncated_probability if whole[0] else 1.0
    second = truncated_probability if whole[1] else 1.0
    along, across = 0.0, 0.0
    for kind in CLASSES:
        along += (
            kind.share
            * side_density(size[0], first, kind.length_m, visible_min_m)
            * side_density(size[1], second, kind.width_m, visible_min_m)
        )
        across += (
            kind.share
            * side_density(size[1], second, kind.length_m, visible_min_m)
            * side_density(size[0], first, kind.width_m, visible_min_m)
        )
    return elementary.log(along / across)


@kernel()
def class_log_odds(size: Floats, whole: Bools, truncated_probability: float) -> Floats:
    """(C,) log-odds of a view of two sides (2,) [m] for each of `CLASSES`, against a piece of a building or a wall.

    A vehicle shows its length and its width, or a single face, which is one of both. Background has any length on a
    logarithmic scale and the depth of a wall, or is a `PAIR`. A view without an untruncated side is little evidence for
    a lorry: the corner of a building that comes into view shows the same.

    Parameters
    ----------
    size, whole, truncated_probability
        As for `length_log_odds`.
    """
    first = (size[0], truncated_probability if whole[0] else 1.0)
    second = (size[1], truncated_probability if whole[1] else 1.0)
    longer, shorter = (first, second) if first >= second else (second, first)
    low, high = BACKGROUND_LENGTH_M
    background = of_background(shorter[0]) / (elementary.log(high / low) * max(longer[0], low))
    if longer[0] > CAR_LENGTH_MAX_M:
        background += PAIR.share * view_density(longer, shorter, PAIR)
    log_odds = np.empty(len(CLASSES))
    piece = longer[1] == 1.0 and (shorter[1] == 1.0 or shorter[0] < FACE_MIN_M)
    for c, kind in enumerate(CLASSES):
        log_odds[c] = elementary.log(view_density(longer, shorter, kind) / background)
        if kind.flat and piece:
            log_odds[c] = min(log_odds[c], PIECE_LOG_ODDS_MAX)
    return log_odds


@kernel()
def view_density(longer: Side, shorter: Side, kind: VehicleClass) -> float:
    """Return the density [1/m^2] of a view of two sides of a class, either of which may be its length, or facing away.

    A side is its visible extent [m] and the probability that it is truncated.
    """
    depth = of_lorry(shorter[0]) if kind.flat else of_car(shorter[0])
    both = 1.0 - kind.end_fraction - kind.side_fraction
    along = side_density(longer[0], longer[1], kind.length_m, 0.0) * (
        kind.side_fraction * depth + both * side_density(shorter[0], shorter[1], kind.width_m, 0.0)
    )
    across = side_density(longer[0], longer[1], kind.width_m, 0.0) * (
        kind.end_fraction * depth + both * side_density(shorter[0], shorter[1], kind.length_m, 0.0)
    )
    return along + across


@kernel()
def side_density(extent: float, truncated: float, limits: tuple[float, float], visible_min_m: float) -> float:
    """Return the density [1/m] of a visible extent [m] of a side from a range of lengths [m], 1 if it may face away.

    The side is `truncated` with this probability.
    """
    if extent <= visible_min_m:
        return 1.0
    low, high = limits
    whole = max(min(high, extent + ROUNDING_M) - max(low, extent), 0.0) / ROUNDING_M
    piece = elementary.log(high / max(low, extent)) if extent < high else 0.0
    return ((1.0 - truncated) * whole + truncated * piece) / (high - low) + OUTLIER_DENSITY
