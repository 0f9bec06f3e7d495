"""Comparison of simulated with real vehicles: a row per figure.

A table of bands states no view of its vehicles, and a vehicle has lines in few bands. Therefore all simulated vehicles
are used, not only the matched ones.
"""

import math
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from luxloop.arrays import Floats, Ints
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.realism import vehicle_figures
from luxloop.scenarios.realism.labelled_vehicle import LabelledVehicle
from luxloop.scenarios.realism.vehicle_figures import ScanLine, keys, lines_over, median, visible_faces
from luxloop.scenarios.statistics.intervals import Interval
from luxloop.scenarios.statistics.jackknife import ANY, cluster_median_interval, ratio_interval

Average = Literal["median", "mean"]


class Figure(NamedTuple):
    """A compared figure."""

    name: str
    """Column of the tables."""
    label: str
    unit: str
    average: Average
    tolerance: float
    """Largest deviation of the simulated average, as a share of the real one."""
    by_quartiles: bool
    """True if a simulated average inside the real quartiles also agrees."""
    scale: float
    """Printed value over that of the tables."""
    digits: int
    """Printed decimals."""


TOLERANCE, METHOD_TOLERANCE = 0.25, 0.5
"""Heading errors have heavy tails, so that their means vary more than medians of shapes."""


def _shape(name: str, label: str, unit: str = "cm", average: Average = "median") -> Figure:
    return Figure(name, label, unit, average, TOLERANCE, True, 100.0 if unit in ("cm", "%") else 1.0, 1)


def _method(name: str) -> Figure:
    label = f"heading error {name}"
    return Figure(f"{name}_error_deg", label, "deg", "mean", METHOD_TOLERANCE, False, 1.0, 2)


def bow_figure(name: str, label: str) -> Figure:
    """Return the bow in a height band as a compared figure."""
    return _shape(name, label)


FIGURES = (
    _shape("bow_end_m", "bow end"),
    _shape("bow_flank_m", "bow flank"),
    _shape("layers_apart_end_m", "layers apart end"),
    _shape("layers_apart_flank_m", "layers apart flank"),
    _shape("std_about_faces_m", "spread about the faces"),
    _shape("line_noise_end_m", "line noise end"),
    _shape("line_noise_flank_m", "line noise flank"),
    _shape("share_10cm_inside", "more than 10 cm inside", "%", "mean"),
    _shape("share_20cm_inside", "more than 20 cm inside", "%", "mean"),
    _shape("share_40cm_inside", "more than 40 cm inside", "%", "mean"),
    _shape("share_10cm_outside", "more than 10 cm outside", "%", "mean"),
    _shape("points_per_m_layer", "points per m and layer", "1/m"),
    _shape("layers", "layers that hit", "1"),
    _shape("share_on_lines", "share on lines", "%"),
    *(_method(name) for name in ("area", "closeness", "variance", "tlinkage", "best")),
)


class Summary(NamedTuple):
    """Average of a figure over vehicles, with its 95 % interval and the quartiles of the vehicles."""

    value: float
    interval: Interval | None
    """None for too few vehicles."""
    quartiles: tuple[float, float]
    n: int
    """Number of values."""


def summarise(values: Floats, vehicle: Ints, average: Average) -> Summary | None:
    """Return the average of the finite `values` (N,) of vehicles (N,), or None without any."""
    finite = np.isfinite(values)
    values, vehicle = values[finite], vehicle[finite]
    if not len(values):
        return None
    low, high = np.quantile(values, (0.25, 0.75))
    value = float(np.median(values) if average == "median" else np.mean(values))
    return Summary(value, _interval(values, vehicle, average), (float(low), float(high)), len(values))


def _interval(values: Floats, vehicle: Ints, average: Average) -> Interval | None:
    if average == "median":
        return cluster_median_interval(vehicle, values)
    return ratio_interval(vehicle, values, np.ones_like(values), ANY)


Verdict = Literal["agrees", "differs", "n/a"]


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
        bow = np.array(
            [
                median([line.bow_m for line in of_vehicle[band.face] if band.from_m <= line.height_m < band.to_m])
                for of_vehicle in lines
            ]
        )
        figure = bow_figure(
            band_column(band.face, band.from_m, band.to_m), f"bow {band.face} {band.from_m:g} to {band.to_m:g} m"
        )
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


def _lines(vehicle: LabelledVehicle) -> Lines:
    """Return the parabolas over ends and over flanks."""
    found: Lines = {"end": [], "flank": []}
    for face in visible_faces(vehicle):
        found["end" if face.end else "flank"] += lines_over(face, vehicle.line, vehicle.points_ego[:, 2])
    return found


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
