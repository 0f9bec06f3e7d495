"""Depth of single faces: how far the points of one visible side of an object lie behind each other.

Flanks and ends of cars are bowed, and their glass is set back; the sides of lorries are boards; background is walls,
fences and posts. A few points on any of them may lie on a line. The densities [1/m] follow the histograms of segments
in recorded scans of seven scenarios with training seeds, which `docs/face_depths.py` prints.
"""

import math

from luxloop.tracker.compiled import kernel

LINE_DEPTH_M = 0.015
"""Mean depth of points on a line, from range noise [m]."""

CAR_LINE_SHARE = 0.1
"""Share of the single faces of cars whose points lie on a line."""

CAR_DEPTH_M = 0.22
"""Most frequent depth of the other ones [m], which have a gamma distribution of shape 2: parts of the bow and of glass
that is set back are seen."""

LORRY_LINE_SHARE = 0.5
"""Share of the single faces of lorries whose points lie on a line; the rest has a small relief."""

LORRY_RELIEF_M = 0.15
"""Mean relief of the other ones [m]."""

BACKGROUND_LINE_SHARE = 0.55
"""Share of background segments whose points lie on a line."""

BACKGROUND_RELIEF_SHARE = 0.35
"""Share of background segments with a small relief; the rest has a corner."""

BACKGROUND_RELIEF_M = 0.15
"""Mean relief of these [m]."""

CORNER_DEPTH_MAX_M = 2.8
"""Depth of a background segment with a corner, at most [m]; deeper ones are no vehicles."""


@kernel()
def of_car(depth_m: float) -> float:
    """Return the density of the depth of a single face of a car, van or motorcycle."""
    bowed = depth_m / CAR_DEPTH_M * exponential(depth_m, CAR_DEPTH_M)
    return CAR_LINE_SHARE * exponential(depth_m, LINE_DEPTH_M) + (1.0 - CAR_LINE_SHARE) * bowed


@kernel()
def of_lorry(depth_m: float) -> float:
    """Return the density of the depth of a single face of a lorry or bus."""
    line, relief = exponential(depth_m, LINE_DEPTH_M), exponential(depth_m, LORRY_RELIEF_M)
    return LORRY_LINE_SHARE * line + (1.0 - LORRY_LINE_SHARE) * relief


@kernel()
def of_background(depth_m: float) -> float:
    """Return the density of the depth of a background segment; deeper ones than vehicles are as dense as corners."""
    line, relief = exponential(depth_m, LINE_DEPTH_M), exponential(depth_m, BACKGROUND_RELIEF_M)
    corner_share = 1.0 - BACKGROUND_LINE_SHARE - BACKGROUND_RELIEF_SHARE
    return (
        BACKGROUND_LINE_SHARE * line + BACKGROUND_RELIEF_SHARE * relief + corner_share / CORNER_DEPTH_MAX_M
    )  # fmt: skip


@kernel()
def exponential(depth_m: float, mean_m: float) -> float:
    """Return the density of an exponential distribution."""
    return math.exp(-depth_m / mean_m) / mean_m
