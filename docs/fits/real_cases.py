"""Fits to the labelled cars of public Ouster recordings, in four layers at bumper height."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from fits.case import Case, case_of
from fits.league_tables import markdown
from twin.counts import four_layers
from twin.headings import FEWEST_POINTS, fit
from twin.labels import load_cars, load_views
from twin.recording import load_frame
from twin.tables import SURE_DEG

from luxloop.scenarios.statistics.jackknife import POSITIVE, ratio_interval
from luxloop.tracker.records import METHODS

BEST, ORACLE = "best", "oracle"


def labelled(folder: Path) -> list[Case]:
    """Return the fits to the unobstructed cars with a heading known to `SURE_DEG`."""
    return list(_labelled(folder))


def _labelled(folder: Path) -> Iterator[Case]:
    cars = load_cars()
    for view in load_views():
        frame = load_frame(folder, view)
        for car in cars:
            if (car.recording, car.frame) != (view.recording, view.frame) or not car.unobstructed:
                continue
            own = four_layers(frame.points_level, -frame.ring, car)
            if len(own) < FEWEST_POINTS or car.heading_sigma_deg > SURE_DEG:
                continue
            linkage, candidates = fit(frame.points_level[own], frame.ring[own])
            box = np.array([car.x_m, car.y_m, np.deg2rad(car.heading_deg), car.length_m, car.width_m])
            name = f"{car.id}, {car.category}\n{car.range_m:.0f} m, label +-{car.heading_sigma_deg:.1f} deg"
            yield case_of(name, frame.points_level[own, :2], linkage.line, candidates, 0, box)


def table(cases: list[Case]) -> str:
    """Return a row per method: mean with its 95 % interval over the cars, median, and the largest error [deg]."""
    car = np.arange(len(cases))
    errors = np.abs([case.errors for case in cases])
    columns = {
        **dict(zip(METHODS, errors.T, strict=True)),
        BEST: np.array([case.worst for case in cases]),
        ORACLE: np.nanmin(errors, axis=1),
    }
    rows = []
    for name, column in columns.items():
        known = np.isfinite(column)
        interval = ratio_interval(car[known], column[known], np.ones(int(known.sum())), POSITIVE)
        ends = f" [{interval[0]:.2f}, {interval[1]:.2f}]" if interval else ""
        quantiles = np.quantile(column[known], (0.5, 0.9, 1.0))
        rows.append((name, f"{column[known].mean():.2f}{ends}", *(f"{value:.2f}" for value in quantiles)))
    return markdown((f"heading error [deg], n = {len(cases)}", "mean [95 %]", "median", "90 %", "largest"), rows)
