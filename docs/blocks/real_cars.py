"""Labelled cars of public Ouster recordings beside their simulated twins: table and picture."""

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

import matplotlib
import numpy as np
import pandas as pd
from blocks import commands, realism
from matplotlib.figure import Figure
from twin import tables
from twin.comparison import Compared, compare
from twin.counts import four_layers, on_car
from twin.labels import Car, load_cars, load_views
from twin.recording import load_frame
from twin.simulated import SENSOR, twin_scan

from luxloop.scenarios.document.figure import STYLE
from luxloop.scenarios.document.palette import PAGE
from luxloop.scenarios.realism import realism_comparison, realism_figures, realism_table, vehicle_figures
from luxloop.scenarios.realism.labelled_vehicle import POINTS_MIN, LabelledVehicle
from luxloop.scenarios.realism.real_table import BANDS

PICTURE = Path(__file__).parents[1] / "pictures" / "realism_real_cars.png"
SEEDS = (11, 12, 13)
"""Seeds of the twins."""
SHOWN = 4
"""Number of cars in the picture."""
PIXELS_PER_INCH = 110


class Pair(NamedTuple):
    """A labelled car with all its points, and in four layers, with its twins."""

    car: Car
    real: LabelledVehicle
    real_layers: LabelledVehicle
    twins: list[LabelledVehicle]
    twin_layers: list[LabelledVehicle]


@cache
def pairs() -> list[Pair]:
    """Return the labelled cars with their twins."""
    return list(load_pairs(commands.real("ouster")))


def table(_name: str) -> str:
    """Return the comparison in four layers."""
    real = [pair.real_layers for pair in pairs() if len(pair.real_layers.points_ego) >= POINTS_MIN]
    twins = [twin for pair in pairs() for twin in pair.twin_layers if len(twin.points_ego) >= POINTS_MIN]
    measured = pd.concat([vehicle_figures.keys(real), vehicle_figures.measure(real)], axis=1)
    comparison = realism_comparison.compare(measured, pd.DataFrame(columns=pd.Index(BANDS)), twins)
    return realism.table(realism_table.document(comparison).data["figures"])


def picture(_name: str) -> None:
    """Draw cars of which an end and a side are visible."""
    draw([pair for pair in pairs() if pair.car.end_seen and pair.car.side_seen])


@cache
def compared() -> list[Compared]:
    """Return the labelled cars with the figures of their twins."""
    return list(compare(commands.real("ouster"), SENSOR))


def counts(_name: str) -> str:
    """Return the errors of the number of points, and the ratio by height."""
    return tables.summary(compared())


def headings(_name: str) -> str:
    """Return the heading errors by method."""
    return tables.heading_table(compared())


def load_pairs(folder: Path) -> Iterator[Pair]:
    """Yield the unobstructed cars of the recordings in a folder."""
    cars = load_cars()
    for view in load_views():
        frame = load_frame(folder, view)
        around = [car for car in cars if (car.recording, car.frame) == (view.recording, view.frame)]
        for car in (car for car in around if car.unobstructed):
            actor = cars.index(car)
            scans = [twin_scan(frame, view, car, around, seed) for seed in SEEDS]
            sides = [
                (frame.points_level, -frame.ring),
                *((points, scan.layer.astype(int)) for points, scan, _ in scans),
            ]
            whole = [vehicle(car, actor, points, ring, np.flatnonzero(on_car(points, car))) for points, ring in sides]
            layers = [vehicle(car, actor, points, ring, four_layers(points, ring, car)) for points, ring in sides]
            yield Pair(car, whole[0], layers[0], whole[1:], layers[1:])


def vehicle(car: Car, actor: int, points: np.ndarray, ring: np.ndarray, own: np.ndarray) -> LabelledVehicle:
    """Return the points `own` of a car in the level frame of its recording, heights above its own ground."""
    return LabelledVehicle(
        data_set=0,
        actor_id=actor,
        frame=car.frame,
        kind=car.category,
        points_ego=np.asarray(points[own], dtype=np.float64) - [0.0, 0.0, car.z_ground_m],
        line=ring[own],
        box=np.array([car.x_m, car.y_m, np.radians(car.heading_deg), car.length_m, car.width_m]),
        lidars=np.zeros((1, 2)),
    )


def draw(pairs: list[Pair]) -> None:
    """Draw real cars above their twins, evenly spaced over their ranges."""
    by_range = sorted(pairs, key=lambda pair: pair.car.range_m)
    shown = [by_range[round(n)] for n in np.linspace(0, len(by_range) - 1, min(SHOWN, len(by_range)))]
    with matplotlib.rc_context(STYLE):
        canvas = Figure(figsize=(10.4, 4.4), layout="constrained", facecolor=PAGE)
        grid = canvas.subplots(2, len(shown), squeeze=False)
        for (above, below), pair in zip(grid.T, shown, strict=True):
            points = realism_figures.plan(above, pair.real)
            realism_figures.plan(below, pair.twins[0])
        grid[0, 0].set_ylabel("real")
        grid[1, 0].set_ylabel("simulated")
        canvas.colorbar(points, ax=list(grid.ravel()), label="height [m]", shrink=0.6)
        canvas.savefig(PICTURE, dpi=PIXELS_PER_INCH, metadata={"Software": None})
