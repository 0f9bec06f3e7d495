"""Layer cuts: a sensor of many rings reduced to the few layers of a low-cost unit.

By elevation, the nearest rings are kept: the view of a four-layer unit at the place of the sensor. By height, the
points near given heights above the ground are kept, the nearest one of each azimuth: the view of a unit at bumper
height. The layers of a sensor on a roof meet near cars at their windows instead.
"""

from dataclasses import dataclass

import numpy as np

from luxloop.arrays import Floats, Ints
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.recordings.sweep import Sweep

OFF_RING_DEG = 0.25
"""[deg] Largest distance from the elevation for points without ring numbers: half the spacing of a 64-ring sensor."""


@dataclass(frozen=True, slots=True, eq=False)
class Rings:
    """Rings of a LIDAR, from its first sweep, so that a ring has the same layer in all sweeps."""

    number: Ints
    """(R,) rising."""
    elevation_deg: Floats
    """(R,) median elevation of the points of each ring [deg]."""

    @classmethod
    def of(cls, sweep: Sweep) -> "Rings":
        """Measure the rings of a sweep; without ring numbers there are none."""
        if sweep.ring is None:
            return cls(np.empty(0, np.int64), np.empty(0))
        number, at = np.unique(sweep.ring, return_inverse=True)
        order = np.argsort(at, kind="stable")
        parts = np.split(_elevation_deg(sweep.points)[order], np.cumsum(np.bincount(at))[:-1])
        return cls(number, np.array([np.median(part) for part in parts if len(part)]))

    def layers(self, sweep: Sweep) -> Ints:
        """(N,) layer of each point if all rings are kept, 0 the lowest; 0 without rings."""
        if sweep.ring is None or not len(self.number):
            return np.zeros(len(sweep), dtype=np.int64)
        rank = np.argsort(np.argsort(self.elevation_deg, kind="stable"), kind="stable")
        at = np.minimum(np.searchsorted(self.number, sweep.ring), len(rank) - 1)
        found: Ints = rank[at]
        return found


@dataclass(frozen=True, slots=True)
class ElevationCut:
    """Keeps the rings nearest to given elevations."""

    elevations_deg: tuple[float, ...]
    """Elevations in the sensor's frame, up positive [deg]."""

    def layers(self, sweep: Sweep, rings: Rings) -> Ints:
        """(N,) layer of each point, 0 the lowest; -1 for points that are not kept."""
        wanted = np.sort(self.elevations_deg)
        layer = np.full(len(sweep), -1, dtype=np.int64)
        if sweep.ring is None:
            elevation = _elevation_deg(sweep.points)
            nearest = np.abs(elevation[:, None] - wanted).argmin(axis=1)
            near = np.abs(elevation - wanted[nearest]) <= OFF_RING_DEG
            layer[near] = nearest[near]
        elif len(rings.number):
            for number, ring in enumerate(np.abs(rings.elevation_deg[:, None] - wanted).argmin(axis=0)):
                layer[sweep.ring == rings.number[ring]] = number
        return layer


@dataclass(frozen=True, slots=True)
class HeightCut:
    """Keeps the points near given heights, the nearest one of each azimuth step."""

    heights_m: tuple[float, ...]
    """Heights above the ground [m]."""
    tolerance_m: float
    """Largest distance from a height [m]."""
    step_deg: float
    """Azimuth step [deg]."""

    def layers(self, sweep: Sweep, height_m: Floats) -> Ints:
        """(N,) layer of each point, 0 the lowest; -1 for points that are not kept.

        Parameters
        ----------
        sweep
            The points.
        height_m
            (N,) their heights above the ground [m].
        """
        wanted = np.sort(self.heights_m)
        x, y, _ = sweep.points.T
        bin_of = np.floor(np.degrees(np.arctan2(y, x)) / self.step_deg).astype(np.int64)
        distance = np.hypot(x, y)
        layer = np.full(len(sweep), -1, dtype=np.int64)
        for number, height in enumerate(wanted):
            near = np.flatnonzero((np.abs(height_m - height) <= self.tolerance_m) & (layer < 0))
            near = near[np.argsort(distance[near], kind="stable")]
            _, first = np.unique(bin_of[near], return_index=True)
            layer[near[first]] = number
        return layer


def numbers(option: str, text: str) -> tuple[float, ...]:
    """Read numbers separated by commas.

    Raises
    ------
    InputError
        The text holds something else, or a number twice.
    """
    try:
        values = tuple(float(part) for part in text.split(","))
    except ValueError:
        values = ()
    if not values or not np.isfinite(values).all() or len(set(values)) < len(values):
        raise InputError(f"{option} {text}: should be different numbers separated by commas")
    return values


def interval(option: str, text: str) -> tuple[float, float]:
    """Read `LOW,HIGH`.

    Raises
    ------
    InputError
        The text holds something else, or LOW is not below HIGH.
    """
    values = numbers(option, text)
    if len(values) != 2 or values[0] >= values[1]:
        raise InputError(f"{option} {text}: should be LOW,HIGH with LOW below HIGH")
    return values[0], values[1]


def _elevation_deg(points: Floats) -> Floats:
    found: Floats = np.degrees(np.arctan2(points[:, 2], np.hypot(points[:, 0], points[:, 1])))
    return found
