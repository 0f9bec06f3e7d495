"""Table of the errors of the paper's steps on simulated and on real vehicles.

The first half of the drive of `paper-campus` is scanned with several bodies, into data sets in the folder `runs`,
which are used again. The real vehicles are 3.8 s of scene 002 of PandaSet (CC BY 4.0, Scale AI and Hesai), cut to four
layers at bumper height.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pandas as pd
from blocks import commands, realism, stamps
from blocks.markdown import markdown

import luxloop
from luxloop.arrays import Bools
from luxloop.scenarios.realism import labelled_fits, labelled_vehicle
from luxloop.scenarios.realism.labelled_vehicle import LabelledVehicle
from luxloop.scenarios.realism.vehicle_figures import visible_faces
from luxloop.scenarios.run.device import NoTracks
from luxloop.sensor_model.bodies.proportions import Draw, car_proportions
from luxloop.sensor_model.bodies.proportions.car_proportions import CarProportions
from luxloop.sensor_model.bodies.proportions.fitting_proportions import Bow
from luxloop.tracker.detection import segmentation, tlinkage
from luxloop.tracker.detection.detector import DetectorConfig
from luxloop.tracker.records import Segments

SCENARIO, DURATION_S, EVERY = "paper-campus", 55.0, 3
"""The first half of the drive; every third frame is fitted."""
FLANKS_M = {"flanks 3 cm": 0.03, "flanks 7 cm": 0.07, "flat flanks": 0.0, "flat flanks and ends": 0.0}
"""Sagitta of the flanks over 1.6 m; ends are bowed as always but in the last set."""
BODIES = ("small_car", "sedan", "estate", "suv", "van")
"""Functions of `car_proportions`."""
RANGES_M = (0, 15, 30, 50)
TOUCHED_M = 0.3
"""Points further from the sides of the box do not count for the view [m]."""
PAPER = "the paper's steps"


def papers_steps(**linkage: Any) -> DetectorConfig:
    """Return the paper's detection, with other settings of T-linkage for comparison."""
    shipped = DetectorConfig()
    paper: dict[str, Any] = {"variant": "paper", "tau_m": 0.08, "points_max": 40, **linkage}
    selection, rectangles = replace(shipped.selection, variant="paper"), replace(shipped.rectangles, halvings=0)
    return replace(shipped, linkage=replace(shipped.linkage, **paper), rectangles=rectangles, selection=selection)


CHANGES: dict[str, DetectorConfig] = {
    PAPER: papers_steps(),
    "all points, no subset of 40": papers_steps(points_max=1000),
    "inliers within 4 cm": papers_steps(tau_m=0.04),
    "inliers within 15 cm": papers_steps(tau_m=0.15),
    "outliers by two perpendicular faces": papers_steps(variant="faces"),
    "default tracker": DetectorConfig(),
}
"""Settings by their names in the table."""


def table(_name: str) -> str:
    """Return mean absolute errors of the selected rectangle, a column per set."""
    folder = commands.RUNS / f"paper-gap-{stamps.runs((stamps.CATALOG,))[-8:]}"
    folder.mkdir(parents=True, exist_ok=True)
    sets = {name: simulated(folder / name.replace(" ", "-"), name) for name in FLANKS_M}
    return table_of({**sets, "real, bumper height": realism.street()})


def table_of(sets: dict[str, list[LabelledVehicle]]) -> str:
    """Return the table of these sets of vehicles."""
    columns = [cells(observations(vehicles)) for vehicles in sets.values()]
    rows = ((name, *(column[name] for column in columns)) for name in columns[0])
    return markdown(("mean absolute error of `best` [deg]", *sets), rows)


def simulated(folder: Path, name: str) -> list[LabelledVehicle]:
    """Return the vehicles of the drive with the bodies of a set."""
    if not folder.is_dir():
        bodies: dict[str, Any] = {made: _bowed(getattr(car_proportions, made), name) for made in BODIES}
        out = folder.with_name(f"{folder.name}-run")
        with mock.patch.multiple(car_proportions, **bodies):
            luxloop.run(SCENARIO, tracker=NoTracks, duration_s=DURATION_S, out=out, dataset_to=folder, ahead=False)
    return [one for one in labelled_vehicle.read(folder, 0, 0.0, 0) if one.frame % EVERY == 0]


def _bowed(make: Callable[[Draw], CarProportions], name: str) -> Callable[[Draw], CarProportions]:
    flat = Bow(0.0, 0.0, 0.0, 0.0)
    ends: dict[str, Any] = {"front_bow": flat, "rear_bow": flat} if "ends" in name else {}
    return lambda draw: replace(make(draw), side_bow=FLANKS_M[name], **ends)


def observations(vehicles: Sequence[LabelledVehicle]) -> pd.DataFrame:
    """Return a row per vehicle: absolute heading errors of `best` by settings [deg], view and range."""
    table = pd.DataFrame({"view": map(view, vehicles), "range_m": [one.range_m for one in vehicles]})
    table["on the end"] = dominant_on_end(vehicles)
    for name, config in CHANGES.items():
        table[name] = np.abs(labelled_fits.fit(vehicles, config).error_deg["best"])
    return table


def cells(table: pd.DataFrame) -> dict[str, object]:
    """Return the cells of a set by the names of their rows."""
    error, views = table[PAPER], table["view"]
    groups = {f"{name} only": views == name for name in ("L-shape", "side", "end")}
    for face, on_end in (("flank", False), ("end", True)):
        groups[f"L-shape, dominant line on the {face}"] = (views == "L-shape") & (table["on the end"] == on_end)
    for low, high in pairwise(RANGES_M):
        groups[f"{low} to {high} m"] = table["range_m"].between(low, high, inclusive="left")
    return {
        "observations": len(table),
        **{name: f"{table[name].mean():.2f}" for name in CHANGES},
        **{name: f"{error[of].mean():.2f} (n = {of.sum()})" if of.any() else "" for name, of in groups.items()},
        "median": f"{error.median():.2f}",
        "above 5 degrees": f"{100 * (error > 5.0).mean():.0f} %",
    }


def view(vehicle: LabelledVehicle) -> str:
    """Return which faces have at least three points over half of an end, or over 1 m of a flank."""
    seen = set()
    for face in visible_faces(vehicle):
        half = 0.5 * vehicle.box[4 if face.end else 3]
        along = face.along[(np.abs(face.depth) < TOUCHED_M) & (np.abs(face.along) < half - 0.2)]
        if len(along) >= 3 and np.ptp(along) > (0.5 if face.end else 1.0):
            seen.add("end" if face.end else "side")
    return "L-shape" if len(seen) == 2 else "".join(seen) or "none"


def dominant_on_end(vehicles: Sequence[LabelledVehicle]) -> Bools:
    """Mask the vehicles whose dominant line, the one with most points, lies across them: on an end."""
    config, sizes = CHANGES[PAPER], [len(vehicle.line) for vehicle in vehicles]
    cloud, lines = (np.concatenate([getattr(one, name) for one in vehicles]) for name in ("points_ego", "line"))
    segments = Segments(np.repeat(np.arange(len(sizes)), sizes), len(sizes))
    points = segmentation.sort_by_segment(cloud, segments, scan_line=lines)
    linkage = tlinkage.link(points, config.linkage, config.lidar)
    found = []
    for vehicle, line in zip(vehicles, np.split(linkage.line, np.cumsum(sizes)[:-1]), strict=True):
        ahead, left = np.linalg.eigh(np.cov(vehicle.points_box[line == 0].T))[1][:, 1]
        found.append(abs(left) > abs(ahead))
    return np.array(found)
