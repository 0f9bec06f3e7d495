"""Scans of flat sides of objects in a plane, by one unit with a beam every half a degree."""

import numpy as np

from luxloop.tracker.scan import Scan

BEARINGS = np.deg2rad(np.arange(-180.0, 180.0, 0.5))
FAR_M = 80.0
"""Range of the background, a circle about the unit."""


def sides(x, y, length, width):
    """Return the four sides (4, 2, 2) of a rectangle along x with its centre at x, y."""
    corner = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)]) * [0.5 * length, 0.5 * width] + [x, y]
    return np.stack([corner, np.roll(corner, -1, axis=0)], axis=1)


def ranges(segments, unit=(0.0, 0.0)):
    """Return the range (B,) of the nearest of segments (K, 2, 2) at each bearing from a unit [m], by Cramer's rule."""
    ray = np.stack([np.cos(BEARINGS), np.sin(BEARINGS)], axis=1)
    nearest = np.full(len(BEARINGS), FAR_M)
    for start, end in np.asarray(segments) - np.asarray(unit):
        along = end - start
        det = ray[:, 0] * -along[1] + ray[:, 1] * along[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = (start[0] * -along[1] + start[1] * along[0]) / det
            fraction = (ray[:, 0] * start[1] - ray[:, 1] * start[0]) / det
        hit = (distance > 0.0) & (fraction >= 0.0) & (fraction <= 1.0)
        nearest = np.where(hit, np.minimum(nearest, distance), nearest)
    return nearest


def scan_of(segments, time=0.0, pose=(0.0, 0.0, 0.0), keep=None):
    """Return the scan of segments (K, 2, 2), relative to the ego, by a unit at its centre; beams of `keep` (B,)."""
    distance = ranges(segments)
    points = np.stack([distance * np.cos(BEARINGS), distance * np.sin(BEARINGS), np.full(len(BEARINGS), 0.6)], axis=1)
    points = points if keep is None else points[keep]
    scan = Scan.from_points(time, points, pose)
    object.__setattr__(scan, "unit_positions_ego", np.zeros((1, 2)))
    return scan
