"""Bow of simulated beside real vehicles by height above the ground.

A table of bands states no view of its vehicles, and a vehicle has lines in few bands. Therefore all simulated vehicles
are used, not only the matched ones.
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from luxloop.scenarios.realism.compared_figures import bow_figure
from luxloop.scenarios.realism.compared_row import ComparedRow
from luxloop.scenarios.realism.face_depth import visible_faces
from luxloop.scenarios.realism.labelled_vehicle import LabelledVehicle
from luxloop.scenarios.realism.scan_lines import ScanLine, lines_over
from luxloop.scenarios.realism.vehicle_figures import keys, median
from luxloop.scenarios.realism.weighted_average import Summary, summarise

OBSERVATIONS_MAX = 1000
"""Largest number of simulated vehicles in frames; more are thinned evenly, as successive frames look alike."""

Lines = dict[str, list[ScanLine]]


def compare(bands: pd.DataFrame, vehicles: Sequence[LabelledVehicle]) -> list[ComparedRow]:
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
    used = vehicles[:: -(-len(vehicles) // OBSERVATIONS_MAX)]
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
