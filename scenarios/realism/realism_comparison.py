"""Comparison of simulated with real vehicles: a row per figure."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.realism import bow_bands, nearest_vehicles, vehicle_figures
from luxloop.scenarios.realism.compared_figures import FIGURES
from luxloop.scenarios.realism.compared_row import ComparedRow
from luxloop.scenarios.realism.labelled_vehicle import LabelledVehicle
from luxloop.scenarios.realism.weighted_average import summarise

FAR = 2.0
"""Distance of views, in scales, beyond which a match is counted as far."""


class Comparison(NamedTuple):
    """Comparison of all figures, with the matched vehicles."""

    rows: list[ComparedRow]
    real: pd.DataFrame
    """Table of the real vehicles."""
    matched: pd.DataFrame
    """Figures of the matched simulated vehicles, with the columns real_row, vehicle (index) and view_distance."""
    vehicles: list[LabelledVehicle]
    """Distinct matched vehicles."""
    observations: int
    """Number of simulated vehicles in frames, matched or not."""

    @property
    def far(self) -> int:
        """Number of real vehicles whose nearest simulated one is further than `FAR`, or that have none."""
        nearest = self.matched.groupby("real_row")["view_distance"].min()
        return len(self.real) - int((nearest <= FAR).sum())


def compare(real: pd.DataFrame, bands: pd.DataFrame, vehicles: Sequence[LabelledVehicle]) -> Comparison:
    """Match simulated vehicles to the real ones and compare their figures.

    Parameters
    ----------
    real, bands
        Tables of `real_table`.
    vehicles
        Simulated vehicles.

    Raises
    ------
    InputError
        No simulated vehicle shows an end that a real one shows.
    """
    if not vehicles:
        raise InputError("the data sets have no graded vehicle with 10 points or more; choose another scenario")
    views = vehicle_figures.keys(vehicles)
    real_row, row, distance = nearest_vehicles.match(real, views)
    if not len(row):
        raise InputError("no simulated vehicle shows the end, front or rear, of a real one; add other data sets")
    distinct, position = np.unique(row, return_inverse=True)
    chosen = [vehicles[index] for index in distinct]
    figures = pd.concat([views.iloc[distinct].reset_index(drop=True), vehicle_figures.measure(chosen)], axis=1)
    matched = figures.iloc[position].assign(real_row=real_row, vehicle=position, view_distance=distance)
    rows = [*bow_bands.compare(bands, vehicles), *_rows(real, matched)]
    return Comparison(rows, real, matched.reset_index(drop=True), chosen, len(vehicles))


def _rows(real: pd.DataFrame, matched: pd.DataFrame) -> list[ComparedRow]:
    """Compare the figures of the real table."""
    actor = matched.groupby(["data_set", "actor_id"]).ngroup().to_numpy(np.int64)
    rows = []
    for figure in FIGURES:
        if figure.name in real:
            of_real = summarise(real[figure.name].to_numpy(np.float64), np.arange(len(real)), figure.average)
            simulated = summarise(matched[figure.name].to_numpy(np.float64), actor, figure.average)
            rows.append(ComparedRow(figure, of_real, simulated))
    return rows
