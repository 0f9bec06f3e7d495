"""Tables of the comparison, in Markdown."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from blocks.markdown import markdown
from twin.pairs import Pair
from twin.unit import in_near_field

from luxloop.arrays import Floats
from luxloop.scenarios.realism import labelled_fits
from luxloop.scenarios.realism.labelled_vehicle import POINTS_MIN, LabelledVehicle

METHODS = ("closeness", "variance", "tlinkage", "best")
BANDS = ("below 55 % of the height", "55 to 70 %", "above 70 %")
SURE_DEG = 1.0
"""[deg] Headings are compared with labels of at most this standard deviation."""


def point_counts(pairs: Sequence[Pair]) -> pd.DataFrame:
    """Return a row per car: its class, and errors and ratios of its twins' points, in the mean over the seeds."""
    rows = []
    for pair in pairs:
        cut, bands = len(pair.real.four_layers()), np.array(pair.real.bands(), dtype=np.float64)
        twin_bands = np.mean([one.bands() for one in pair.twins], axis=0)
        row = {
            "near": in_near_field(pair.car),
            "pickup": pair.car.category == "pickup",
            "length_seen": pair.car.length_seen,
            "error": 100.0 * (np.mean([len(one) for one in pair.twins]) / len(pair.real) - 1.0),
            "cut error": 100.0 * (np.mean([len(one.four_layers()) for one in pair.twins]) - cut) / max(cut, 1),
        }
        rows.append(row | dict(zip(BANDS, twin_bands / np.where(bands > 0.0, bands, np.nan), strict=True)))
    return pd.DataFrame(rows)


def summary(pairs: Sequence[Pair]) -> str:
    """Return the mean absolute percentage errors, and the ratio of points by height."""
    table = point_counts(pairs)
    far = table[~table["near"]]
    no_pickups = far[~far["pickup"]]
    sized = no_pickups[no_pickups["length_seen"]]
    groups = {"all": table, "not in the near field": far, "and no pickups": no_pickups, "and the size seen": sized}
    rows = []
    for name, group in groups.items():
        error = group["error"]
        figures = (error.abs().mean(), error.abs().median(), error.mean(), group["cut error"].abs().mean())
        rows.append((name, len(group), *(f"{figure:.1f} %" for figure in figures)))
    errors = markdown(("cars", "n", "mean absolute error", "median", "bias", "four layers"), rows)
    ratios = [(band, f"{table[band].median():.2f}") for band in BANDS]
    return f"{errors}\n\n{markdown(('points by height', 'twin over real (median)'), ratios)}"


def heading_table(pairs: Sequence[Pair]) -> str:
    """Return mean and median absolute heading errors by method, of cars with a well-known heading."""
    real, twins = ({name: np.abs(error) for name, error in errors.items()} for errors in heading_errors(pairs))
    head = (f"heading error [deg], n = {len(real['best'])}", "mean", "median", "twin mean", "twin median")
    errors = ((method, real[method], twins[method]) for method in METHODS)
    rows = (
        (method, *(f"{figure(error):.2f}" for error in both for figure in (np.mean, np.median)))
        for method, *both in errors
    )
    return markdown(head, rows)


def heading_errors(pairs: Sequence[Pair]) -> tuple[dict[str, Floats], dict[str, Floats]]:
    """Return the errors of the fits in four layers by method [deg], of cars with a well-known heading and of twins."""
    real, twins = [], []
    for number, pair in enumerate(pairs):
        car = pair.real.four_layers().vehicle(number)
        if len(car.line) >= POINTS_MIN and pair.car.heading_sigma_deg <= SURE_DEG:
            real.append(car)
            twins += [one.four_layers().vehicle(number) for one in pair.twins]
    return labelled_fits.fit(real).error_deg, labelled_fits.fit(enough(twins)).error_deg


def enough(vehicles: Sequence[LabelledVehicle]) -> list[LabelledVehicle]:
    """Return the vehicles with enough points for statistics."""
    return [vehicle for vehicle in vehicles if len(vehicle.line) >= POINTS_MIN]
