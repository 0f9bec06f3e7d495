"""Cars with exact poses, scanned from the origin: near-perfect outlines for tests of the whole tracker."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from support.shapes import Car, scan_car

from luxloop.tracker.records import Status, Tracks
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import Tracker

Floats = npt.NDArray[np.float64]

SIZE = (4.6, 1.8)
OVERHANG_M = 0.9
"""Distance of the rear axle from the rear end."""


def driven(start: Sequence[float], speed_mps: float, yaw_rate: Floats, dt_s: float) -> Floats:
    """Return (K, 3) poses of the centre of a car whose rear axle starts at (x, y, yaw), with yaw rates (K,)."""
    fine = 20
    rate = np.repeat(yaw_rate, fine)
    yaw = start[2] + np.cumsum(rate) * dt_s / fine
    path = np.cumsum(np.exp(1j * (yaw - 0.5 * rate * dt_s / fine))) * speed_mps * dt_s / fine
    center = complex(*start[:2]) + path + (0.5 * SIZE[0] - OVERHANG_M) * np.exp(1j * yaw)
    return np.column_stack([center.real, center.imag, yaw])[fine - 1 :: fine]


def scan_of(poses: Floats, time_s: float, rng: np.random.Generator, size: tuple[float, float] = SIZE) -> Scan:
    """Return one scan of cars (C, 3), none of which hides another, with a range noise of 5 mm."""
    cars = [
        Car((x, y), yaw, size, chamfer=0.05, range_std=0.005, layer_bias=(0.0,) * 4) for x, y, yaw in poses.tolist()
    ]
    points = np.concatenate([scan_car(car, rng)[0] for car in cars])
    return Scan.from_points(time_s, np.column_stack([points, np.full(len(points), 0.6)]))


def track(poses: Floats, dt_s: float, tracker: Tracker | None = None) -> list[Tracks]:
    """Return the tracks after each frame of cars (K, C, 3), scanned every `dt_s`."""
    tracker, rng = tracker or Tracker(), np.random.default_rng(4)
    return [tracker.step(scan_of(row, k * dt_s, rng))[0] for k, row in enumerate(poses)]


def confirmed(tracks: Tracks) -> npt.NDArray[np.int64]:
    """Indices of the confirmed tracks."""
    return np.flatnonzero(tracks.status == Status.CONFIRMED)
