"""Comparison of simulated with real vehicles: a row per figure."""

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
import pandas as pd

from scenarios.errors import InputError
from scenarios.realism import nearest_vehicles, vehicle_figures
from scenarios.realism.compared_figures import FIGURES, Figure, bow_figure
from scenarios.realism.labelled_vehicle import LabelledVehicle
from scenarios.realism.vehicle_figures import band_column
from scenarios.realism.weighted_average import Summary, summarise

Verdict = Literal["agrees", "differs", "n/a"]

FAR = 2.0
"""Distance of views, in scales, beyond which a match is counted as far."""


class ComparedRow(NamedTuple):
    """A figure of real and of simulated vehicles."""

    figure: Figure
    real: Summary | None
    simulated: Summary | None

    @property
    def verdict(self) -> Verdict:
        """Verdict by the figure's tolerance and the real quartiles."""
        if self.real is None or self.simulated is None:
            return "n/a"
        value, (low, high) = self.simulated.value, self.real.quartiles
        near = abs(value - self.real.value) <= self.figure.tolerance * abs(self.real.value)
        return "agrees" if near or (self.figure.by_quartiles and low <= value <= high) else "differs"


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
    figures = pd.concat([views.iloc[distinct].reset_index(drop=True), vehicle_figures.measure(chosen, bands)], axis=1)
    matched = figures.iloc[position].assign(real_row=real_row, vehicle=position, view_distance=distance)
    return Comparison(_rows(real, bands, matched), real, matched.reset_index(drop=True), chosen, len(vehicles))


def _rows(real: pd.DataFrame, bands: pd.DataFrame, matched: pd.DataFrame) -> list[ComparedRow]:
    actor = matched.groupby(["data_set", "actor_id"]).ngroup().to_numpy(np.int64)

    def simulated(figure: Figure) -> Summary | None:
        return summarise(matched[figure.name].to_numpy(np.float64), actor, figure.average)

    rows = []
    for band in bands.itertuples():
        label = f"bow {band.face} {band.from_m:g} to {band.to_m:g} m"
        figure = bow_figure(band_column(band.face, band.from_m, band.to_m), label)
        quartiles = (band.lower_quartile_m, band.upper_quartile_m)
        rows.append(ComparedRow(figure, Summary(band.median_m, None, quartiles, int(band.vehicles)), simulated(figure)))
    for figure in FIGURES:
        if figure.name in real:
            values = real[figure.name].to_numpy(np.float64)
            rows.append(ComparedRow(figure, summarise(values, np.arange(len(real)), figure.average), simulated(figure)))
    return rows
