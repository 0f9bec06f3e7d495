"""Straight runs: thin rows of points without gaps, longer than the flank of a car, found by a Hough transform."""

import math
from dataclasses import dataclass

import numpy as np

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.detection.segmentation import SegmentationConfig
from luxloop.tracker.records import NOT_USED

ANGLES = np.arange(0.0, math.pi, math.radians(3.0))
"""Directions of the normals of lines [rad]; the fit that follows finds the angle between two of them."""

FITS = 3
"""Fits of a line to the points in its band: the bands of the first ones leave out the ends of a long wall."""

TRIALS = 8
"""Lines to try in one segment."""


@dataclass(frozen=True, slots=True)
class WallConfig:
    """Shape of straight parts of walls."""

    length_min_m: float = 6.0
    """Minimum length of a straight part of a wall [m]; the flank of a van is shorter."""
    half_width_m: float = 0.25
    """Maximum distance of its points from the line [m]: range noise, calibration errors, pilasters."""
    beam_rad: float = math.radians(0.5)
    """Angle between beams of one layer [rad]; three of them, on a surface seen at a grazing angle, are no gap."""
    gap_m: float = 0.25
    """Maximum gap on a surface that is seen frontally [m]."""

    def __post_init__(self) -> None:
        for name in ("length_min_m", "half_width_m", "beam_rad", "gap_m"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} is {getattr(self, name)}; give a value above 0")


def straight_runs(points: Floats, config: WallConfig, segmentation: SegmentationConfig) -> tuple[Ints, Ints]:
    """Return the straight run (P,) and the line (P,) of each point, `NOT_USED` for points on none.

    Points (P, 2) are relative to the ego's centre [m]. A line may have several runs, with gaps between them.
    """
    found, line_of = np.full(len(points), NOT_USED), np.full(len(points), NOT_USED)
    cells = thinned(points, config.half_width_m)
    left = np.ones(len(cells), np.bool_)
    needed = max(2.0, 0.5 * config.length_min_m / config.half_width_m)  # half of a run's cells
    for trial in range(TRIALS):
        candidates = np.flatnonzero(left)
        if len(candidates) < needed:
            break
        band = candidates[densest_line(cells[candidates], config.half_width_m)]
        if len(band) < needed:
            break
        line = fitted(cells, band, config.half_width_m)
        near = left & (np.abs(cells @ line[:2] - line[2]) <= 2.0 * config.half_width_m)
        near[band] = True
        left &= ~near
        on_line = np.flatnonzero((found == NOT_USED) & (np.abs(points @ line[:2] - line[2]) <= config.half_width_m))
        run = unbroken(points[on_line], line, config, segmentation)
        run[run != NOT_USED] += found.max(initial=NOT_USED) + 1
        found[on_line] = run
        line_of[on_line] = trial
    return found, line_of


def thinned(points: Floats, pitch: float) -> Floats:
    """(C, 2) means of points (P, 2) by square cells [m].

    A line's votes then follow its length, not the density of its points.
    """
    column, row = np.floor(points / pitch).astype(np.int64).T
    _, member, count = np.unique((column << 32) + row, return_inverse=True, return_counts=True)
    sums = np.stack([np.bincount(member, axis, len(count)) for axis in points.T], axis=1)
    return np.asarray(sums / count[:, None])


def densest_line(cells: Floats, half_width: float) -> Ints:
    """Return the cells (C, 2) in the band of a line that holds most of them; bands do not overlap."""
    offset = cells @ np.array([np.cos(ANGLES), np.sin(ANGLES)])
    band = np.floor(offset / (2.0 * half_width)).astype(np.int64)
    band -= band.min()
    width = int(band.max()) + 1
    votes = np.bincount((band + width * np.arange(len(ANGLES))).ravel(), minlength=width * len(ANGLES))
    best = int(votes.argmax())
    return np.flatnonzero(band[:, best // width] == best % width)


def fitted(cells: Floats, band: Ints, half_width: float) -> Floats:
    """Return a line's unit normal and offset (3,): principal axes of the cells in its band, which follows the fit."""
    line = np.zeros(3)
    for _ in range(FITS):
        mean = cells[band].mean(axis=0)
        away = cells[band] - mean
        line[:2] = np.linalg.eigh(away.T @ away)[1][:, 0]
        line[2] = line[:2] @ mean
        inside = np.flatnonzero(np.abs(cells @ line[:2] - line[2]) <= half_width)
        if len(inside) < len(band):
            break
        band = inside
    return line


def unbroken(points: Floats, line: Floats, config: WallConfig, segmentation: SegmentationConfig) -> Ints:
    """(P,) run of each point on a line: parts without gaps that are long enough, numbered along the line."""
    if not len(points):
        return np.empty(0, dtype=np.int64)
    along = points @ np.array([-line[1], line[0]])
    order = np.argsort(along)
    along = along[order]
    range_m = np.hypot(along, line[2])
    grazing = config.gap_m + 3.0 * config.beam_rad * range_m**2 / max(abs(float(line[2])), config.gap_m)
    limit = np.minimum(segmentation.radius_m + segmentation.radius_per_m * range_m, grazing)
    broken = np.diff(along, prepend=along[0]) > np.maximum(limit, np.append(limit[0], limit[:-1]))
    piece = np.cumsum(broken)
    start = np.searchsorted(piece, np.arange(piece[-1] + 1))
    length = np.maximum.reduceat(along, start) - along[start]
    run = np.empty(len(points), dtype=np.int64)
    long = length >= config.length_min_m
    run[order] = np.where(long, np.cumsum(long) - 1, NOT_USED)[piece]
    return run
