"""Comparison of simulated with real vehicles: a row per figure.

A table of bands states no view of its vehicles, and a vehicle has lines in few bands. Therefore all simulated vehicles
are used, not only the matched ones.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.realism import vehicle_figures
from luxloop.scenarios.realism.compared_figures import FIGURES, ComparedRow, Summary, bow_figure, summarise
from luxloop.scenarios.realism.labelled_vehicle import LabelledVehicle
from luxloop.scenarios.realism.vehicle_figures import ScanLine, keys, lines_over, median, visible_faces

OBSERVATIONS_MAX = 1000
"""Largest number of simulated vehicles in frames; more are thinned, as successive frames look alike."""
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
"""Step of the thinning, as a share of all: a whole step would take the same vehicles of each frame."""

Lines = dict[str, list[ScanLine]]


def compare_bow(bands: pd.DataFrame, vehicles: Sequence[LabelledVehicle]) -> list[ComparedRow]:
    """Compare the bow in each band of a table; a vehicle in a frame has the median of its lines.

    Parameters
    ----------
    bands
        Table of `real_table.read_bands`.
    vehicles
        At least one simulated vehicle.
    """
    if bands.empty:
        return []
    used = thinned(vehicles)
    actor = keys(used).groupby(["data_set", "actor_id"]).ngroup().to_numpy(np.int64)
    lines = [_lines(vehicle) for vehicle in used]
    rows = []
    for band in bands.itertuples():
        bow = np.array([_bow(of_vehicle[band.face], band.from_m, band.to_m) for of_vehicle in lines])
        figure = bow_figure(band_column(band.face, band.from_m, band.to_m), _label(band.face, band.from_m, band.to_m))
        quartiles = (band.lower_quartile_m, band.upper_quartile_m)
        real = Summary(band.median_m, None, quartiles, int(band.vehicles))
        rows.append(ComparedRow(figure, real, summarise(bow, actor, figure.average)))
    return rows


def thinned(vehicles: Sequence[LabelledVehicle]) -> list[LabelledVehicle]:
    """Return at most `OBSERVATIONS_MAX` of the vehicles, evenly from all."""
    if len(vehicles) <= OBSERVATIONS_MAX:
        return list(vehicles)
    share = np.arange(OBSERVATIONS_MAX) * GOLDEN % 1.0
    return [vehicles[index] for index in np.unique((share * len(vehicles)).astype(np.int64))]


def band_column(face: str, from_m: float, to_m: float) -> str:
    """Return the name of the bow in a height band."""
    return f"bow_{face}_{from_m:g}_{to_m:g}_m"


def _label(face: str, from_m: float, to_m: float) -> str:
    return f"bow {face} {from_m:g} to {to_m:g} m"


def _lines(vehicle: LabelledVehicle) -> Lines:
    """Return the parabolas over ends and over flanks."""
    found: Lines = {"end": [], "flank": []}
    for face in visible_faces(vehicle):
        found["end" if face.end else "flank"] += lines_over(face, vehicle.line, vehicle.points_ego[:, 2])
    return found


def _bow(lines: list[ScanLine], from_m: float, to_m: float) -> float:
    return median([line.bow_m for line in lines if from_m <= line.height_m < to_m])


RANGE_SCALE = 0.15
"""Difference of log ranges that counts as 1."""
ASPECT_SCALE_DEG = 8.0
"""Difference of aspects that counts as 1 [deg]."""
NEAREST = 3
"""Simulated vehicles per real one."""


def match(real: pd.DataFrame, simulated: pd.DataFrame) -> tuple[Ints, Ints, Floats]:
    """Return the nearest simulated vehicles with the same end seen for every real one.

    Parameters
    ----------
    real, simulated
        Tables with the columns range_m, aspect_deg and front_seen.

    Returns
    -------
    real_row
        (M,) rows of the real table; those without a simulated vehicle that shows the same end are missing.
    simulated_row
        (M,) rows of the simulated one, up to `NEAREST` for each real row.
    distance
        (M,) distance of the views, in scales.
    """
    rows: list[tuple[int, int, float]] = []
    for front in (False, True):
        ours, theirs = (np.flatnonzero(table["front_seen"].to_numpy() == front) for table in (simulated, real))
        count = min(NEAREST, len(ours))
        if not count or not len(theirs):
            continue
        distance, index = cKDTree(_view(simulated.iloc[ours])).query(_view(real.iloc[theirs]), k=range(1, count + 1))
        rows += zip(np.repeat(theirs, count), ours[index.ravel()], distance.ravel(), strict=True)
    rows.sort(key=lambda row: row[0])
    real_row, simulated_row, gap = (np.array(column) for column in zip(*rows, strict=True)) if rows else ([], [], [])
    return np.asarray(real_row, np.int64), np.asarray(simulated_row, np.int64), np.asarray(gap, np.float64)


def _view(table: pd.DataFrame) -> Floats:
    """(N, 2) log range and aspect, in scales."""
    view: Floats = np.column_stack([np.log(table["range_m"]) / RANGE_SCALE, table["aspect_deg"] / ASPECT_SCALE_DEG])
    return view


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
    real_row, row, distance = match(real, views)
    if not len(row):
        raise InputError("no simulated vehicle shows the end, front or rear, of a real one; add other data sets")
    distinct, position = np.unique(row, return_inverse=True)
    chosen = [vehicles[index] for index in distinct]
    figures = pd.concat([views.iloc[distinct].reset_index(drop=True), vehicle_figures.measure(chosen)], axis=1)
    matched = figures.iloc[position].assign(real_row=real_row, vehicle=position, view_distance=distance)
    rows = [*compare_bow(bands, vehicles), *_rows(real, matched)]
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
