"""Shape of the scan lines across a face: bow, noise about a parabola, and distance between lines."""

from dataclasses import dataclass

import numpy as np

from luxloop.scenarios.arrays import Bools, Floats, Ints
from luxloop.scenarios.realism.face_depth import Face

POINTS_MIN = 7
"""Least number of points of a parabola."""
OUTLIER_SIGMAS = 3.0
EXACT_M = 1e-6
"""[m] Residuals below are rounding errors, not outliers."""
MIDDLE_POINTS_MIN = 3
"""Least number of points of the median depth of a line."""
SIGMA_PER_MAD = 1.4826
"""Standard deviation of a normal distribution over its median absolute deviation."""


@dataclass(frozen=True, slots=True)
class Window:
    """Part of a face that is measured, for ends or flanks [m]."""

    half_m: float
    """Half-width of the parabola."""
    span_min_m: float
    """Least extent of its points."""
    middle_m: float
    """Half-width of the middle, where the lines' depths are compared."""
    depth_max_m: float
    """Largest depth of the points of a parabola: hoods lie behind an end, only seats and panes behind a flank."""
    middle_depth_max_m: float
    """Largest depth of the points of the middle."""


END, FLANK = Window(0.75, 1.0, 0.45, 1.2, 1.2), Window(1.6, 2.0, 1.2, 0.3, 0.6)


@dataclass(frozen=True, slots=True)
class ScanLine:
    """Parabola through one scan line over a face."""

    bow_m: float
    """Sagitta over the window's half-width, positive if the middle stands out."""
    noise_m: float
    """Standard deviation of the points about the parabola."""
    height_m: float
    """Median height of the points above the ground."""


def lines_over(face: Face, line: Ints, height: Floats) -> list[ScanLine]:
    """Return the parabolas of the scan lines over a face that have enough points over enough of its width.

    Parameters
    ----------
    face
        Face with N points.
    line
        (N,) scan line of each point.
    height
        (N,) height of each point above the ground [m].
    """
    window = window_of(face)
    near = (np.abs(face.along) <= window.half_m) & (face.depth <= window.depth_max_m)
    found = []
    for number in np.unique(line[near]):
        own = near & (line == number)
        if own.sum() >= POINTS_MIN and np.ptp(face.along[own]) >= window.span_min_m:
            bow, noise = parabola(face.along[own], face.depth[own], window.half_m)
            found.append(ScanLine(bow, noise, float(np.median(height[own]))))
    return found


def parabola(along: Floats, depth: Floats, half_m: float) -> tuple[float, float]:
    """Fit a parabola to points (N,) of a scan line; return its sagitta over `half_m` and the noise about it [m].

    Points beyond three robust standard deviations of a first fit are left out of the second one.
    """
    residual = depth - np.polyval(np.polyfit(along, depth, 2), along)
    sigma = SIGMA_PER_MAD * np.median(np.abs(residual))
    kept: Bools = np.abs(residual) <= max(OUTLIER_SIGMAS * sigma, EXACT_M)
    if kept.sum() < POINTS_MIN:
        kept[:] = True
    curve = np.polyfit(along[kept], depth[kept], 2)
    residual = (depth - np.polyval(curve, along))[kept]
    return float(curve[0] * half_m**2), float(np.sqrt(np.mean(residual**2)))


def layers_apart(face: Face, line: Ints) -> float:
    """Return the spread of the median depths of the scan lines (N,) in the middle of a face [m]; NaN for one line."""
    window = window_of(face)
    middle = (np.abs(face.along) <= window.middle_m) & (face.depth <= window.middle_depth_max_m)
    numbers, counts = np.unique(line[middle], return_counts=True)
    lines = numbers[counts >= MIDDLE_POINTS_MIN]
    if len(lines) < 2:
        return float("nan")
    return float(np.ptp([np.median(face.depth[middle & (line == number)]) for number in lines]))


def window_of(face: Face) -> Window:
    """Return the window of a face."""
    return END if face.end else FLANK
