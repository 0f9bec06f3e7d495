"""Points of the labelled cars beside those of their simulated twins."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from twin.labels import Car, load_cars, load_views
from twin.recording import load_frame
from twin.simulated import twin_scan

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.realism import labelled_vehicle
from luxloop.scenarios.realism.labelled_vehicle import LabelledVehicle

SEEDS = (11, 12, 13, 14, 15)
"""Seeds of the twins."""
CUT_M = (0.45, 0.95)
"""Heights over the ground of the four-layer cut."""
LAYERS, STEP_DEG = 4, 0.5


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """Points on a car, recorded or simulated."""

    car: Car
    points_level: Floats
    """(N, 3) in the level frame of the recording [m]."""
    layer: Ints
    """(N,) ring, counted upwards."""

    def __len__(self) -> int:
        return len(self.layer)

    def bands(self) -> tuple[int, int, int]:
        """Count the points below 55 %, from 55 to 70 %, and above 70 % of the height.

        The lowest band is the body, the highest one mostly glass and roof.
        """
        share = self.car.in_box(self.points_level)[:, 2] / self.car.height_m
        below, upto = int((share < 0.55).sum()), int((share < 0.70).sum())
        return below, upto - below, len(self) - upto

    def four_layers(self) -> "Seen":
        """Return the points in four rings, as a unit of four layers at bumper height sees the car.

        Of the rings whose median height on the car is within `CUT_M`, four are chosen evenly, and of each ring one
        point per `STEP_DEG`. They are in the order of azimuth, left to right, ring by ring from below.
        """
        height = self.car.in_box(self.points_level)[:, 2]
        median = {layer: float(np.median(height[self.layer == layer])) for layer in np.unique(self.layer)}
        within = sorted((layer for layer, at in median.items() if CUT_M[0] <= at <= CUT_M[1]), key=median.__getitem__)
        if len(within) > LAYERS:
            within = [within[round(k)] for k in np.linspace(0, len(within) - 1, LAYERS)]
        x, y, _ = self.points_level.T
        azimuth = np.rad2deg(np.arctan2(y, x) - np.arctan2(self.car.y_m, self.car.x_m))
        to_the_right = -((azimuth + 180.0) % 360.0 - 180.0)
        chosen = [np.empty(0, np.int64)]
        for layer in within:
            row = np.flatnonzero(self.layer == layer)
            row = row[np.argsort(to_the_right[row], kind="stable")]
            chosen.append(row[np.unique(np.floor(to_the_right[row] / STEP_DEG), return_index=True)[1]])
        rows = np.concatenate(chosen)
        return Seen(self.car, self.points_level[rows], self.layer[rows])

    def vehicle(self, actor_id: int) -> LabelledVehicle:
        """Return the points with their label, heights above the car's own ground."""
        points = np.asarray(self.points_level, dtype=np.float64) - [0.0, 0.0, self.car.z_ground_m]
        label = (0, actor_id, self.car.frame, self.car.category)
        return LabelledVehicle(*label, points, self.layer, self.car.box, lidars=np.zeros((1, 2)))


class Pair(NamedTuple):
    """A labelled car and its twins, one for each seed."""

    car: Car
    real: Seen
    twins: list[Seen]


def pairs(folder: Path, seeds: tuple[int, ...] = SEEDS) -> Iterator[Pair]:
    """Yield the unobstructed cars of the recordings in a folder, each with its twins."""
    cars = load_cars()
    for view in load_views():
        frame = load_frame(folder, view)
        around = [car for car in cars if (car.recording, car.frame) == (view.recording, view.frame)]
        for car in (car for car in around if car.unobstructed):
            scans = [twin_scan(frame, view, car, around, seed) for seed in seeds]
            yield Pair(car, seen(car, frame.points_level, -frame.ring), [seen(car, *scan) for scan in scans])


def seen(car: Car, points_level: Floats, layer: Ints) -> Seen:
    """Return the points of a scan on a car."""
    own = on_car(points_level, car)
    return Seen(car, points_level[own], layer[own])


def on_car(points_level: Floats, car: Car) -> Bools:
    """Return the (N,) mask of the points on a car, with the margins of labelled vehicles."""
    return labelled_vehicle.in_box(points_level - [0.0, 0.0, car.z_ground_m], car.box, car.height_m)
