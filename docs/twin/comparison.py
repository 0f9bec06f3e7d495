"""Comparison of every labelled car with its simulated twins: counts, height bands and headings."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from twin.counts import four_layers, height_bands, on_car
from twin.headings import FEWEST_POINTS, heading_errors
from twin.labels import Car, load_cars, load_views
from twin.recording import load_frame
from twin.simulated import SENSOR, twin_scan

from luxloop.sensor_model.sensor_config import SensorConfig

SEEDS = (11, 12, 13, 14, 15)


@dataclass(frozen=True, slots=True)
class Compared:
    """A labelled car and its twins; simulated figures are means over the seeds."""

    car: Car
    count: int
    """Points on the car."""
    twin_count: float
    cut_count: int
    """Points in the four-layer cut."""
    twin_cut_count: float
    bands: tuple[int, ...]
    """Points by height, see `height_bands`."""
    twin_bands: tuple[float, ...]
    errors: dict[str, float]
    """Heading errors by method [deg]; empty with too few points."""
    twin_errors: list[dict[str, float]]
    """The same of each twin, against its true heading."""

    @property
    def percentage_error(self) -> float:
        """Error of the twin's count, positive if it has more points [%]."""
        return 100.0 * (self.twin_count - self.count) / self.count

    @property
    def cut_percentage_error(self) -> float:
        """As `percentage_error`, in the four-layer cut."""
        return 100.0 * (self.twin_cut_count - self.cut_count) / max(self.cut_count, 1)


def compare(folder: Path, sensor: SensorConfig = SENSOR, seeds: tuple[int, ...] = SEEDS) -> Iterator[Compared]:
    """Compare the unobstructed cars of the recordings in a folder."""
    cars = load_cars()
    for view in load_views():
        frame = load_frame(folder, view)
        around = [car for car in cars if (car.recording, car.frame) == (view.recording, view.frame)]
        for car in around:
            if not car.unobstructed:
                continue
            scans = [twin_scan(frame, view, car, around, seed, sensor) for seed in seeds]
            twins = [(points, scan.layer) for points, scan, _ in scans]
            cut = four_layers(frame.points_level, -frame.ring, car)
            cuts = [four_layers(points, layer, car) for points, layer in twins]
            yield Compared(
                car=car,
                count=int(on_car(frame.points_level, car).sum()),
                twin_count=float(np.mean([on_car(points, car).sum() for points, _ in twins])),
                cut_count=len(cut),
                twin_cut_count=float(np.mean([len(chosen) for chosen in cuts])),
                bands=height_bands(frame.points_level, car),
                twin_bands=tuple(np.mean([height_bands(points, car) for points, _ in twins], axis=0).tolist()),
                errors=_errors(frame.points_level[cut], frame.ring[cut], car),
                twin_errors=[
                    _errors(points[chosen], layer[chosen], car)
                    for (points, layer), chosen in zip(twins, cuts, strict=True)
                ],
            )


def _errors(points: np.ndarray, scan_line: np.ndarray, car: Car) -> dict[str, float]:
    return heading_errors(points, scan_line, car.heading_deg) if len(points) >= FEWEST_POINTS else {}
