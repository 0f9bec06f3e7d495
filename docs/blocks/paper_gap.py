"""Errors of the paper's steps on simulated and on real vehicles: table and picture.

The first half of the drive of `paper-campus` is scanned with several bodies, into data sets in the folder `runs`,
which are used again. The real vehicles are 3.8 s of scene 002 of PandaSet (CC BY 4.0, Scale AI and Hesai), cut to four
layers at bumper height.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

import matplotlib
import numpy as np
import numpy.typing as npt
from blocks import commands, realism, stamps
from blocks.markdown import markdown
from matplotlib.figure import Figure

from luxloop.scenarios import interface
from luxloop.scenarios.document.figure import STYLE
from luxloop.scenarios.document.palette import PAGE as PAPER
from luxloop.scenarios.realism import labelled_fits, labelled_vehicle
from luxloop.scenarios.realism.labelled_vehicle import LabelledVehicle
from luxloop.scenarios.realism.vehicle_figures import (
    visible_faces,
)
from luxloop.scenarios.report.paper_comparison import HEADING_ABS_DEG
from luxloop.scenarios.run.device import NoTracks
from luxloop.sensor_model.bodies.proportions import Draw, car_proportions
from luxloop.sensor_model.bodies.proportions.car_proportions import CarProportions
from luxloop.sensor_model.bodies.proportions.fitting_proportions import Bow
from luxloop.tracker.detection import segmentation, tlinkage
from luxloop.tracker.detection.detector import DetectorConfig
from luxloop.tracker.records import Segments

PICTURE = Path(__file__).parents[1] / "pictures" / "paper_gap.png"
PIXELS_PER_INCH = 110
SCENARIO, DURATION_S, EVERY = "paper-campus", 55.0, 3
"""The first half of the drive; every third frame is fitted."""
FLANKS_M = {"flanks 3 cm": 0.03, "flanks 7 cm": 0.07, "flat flanks": 0.0, "flat flanks and ends": 0.0}
"""Sagitta of the flanks over 1.6 m; ends are bowed as always but in the last set."""
RANGES_M = ((0, 15), (15, 30), (30, 50))

Floats = npt.NDArray[np.float64]


def papers_steps(variant: str = "paper", tau_m: float = 0.08, points_max: int = 40) -> DetectorConfig:
    """Return the paper's detection, with other settings of T-linkage for comparison."""
    shipped = DetectorConfig()
    return replace(
        shipped,
        linkage=replace(shipped.linkage, variant=variant, tau_m=tau_m, points_max=points_max),
        rectangles=replace(shipped.rectangles, halvings=0),
        selection=replace(shipped.selection, variant="paper"),
    )


CHANGES: dict[str, DetectorConfig] = {
    "the paper's steps": papers_steps(),
    "all points, no subset of 40": papers_steps(points_max=1000),
    "inliers within 4 cm": papers_steps(tau_m=0.04),
    "inliers within 15 cm": papers_steps(tau_m=0.15),
    "outliers by two perpendicular faces": papers_steps("faces"),
    "default tracker": DetectorConfig(),
}
"""Settings by their names in the table."""


@cache
def sets() -> dict[str, list[LabelledVehicle]]:
    """Return the vehicles of each set."""
    cache_folder = commands.RUNS / f"paper-gap-{stamps.runs((stamps.CATALOG,))[-8:]}"
    cache_folder.mkdir(parents=True, exist_ok=True)
    found = {name: simulated(cache_folder / name.replace(" ", "-"), name) for name in FLANKS_M}
    return found | {"real, bumper height": realism.street()}


def block(_name: str) -> str:
    """Return the table."""
    return table(sets())


def picture(_name: str) -> None:
    """Draw the picture."""
    draw(sets())


def simulated(folder: Path, name: str) -> list[LabelledVehicle]:
    """Return the vehicles of the drive with the bodies of a set."""
    if not folder.is_dir():
        makers = {made: getattr(car_proportions, made) for made in ("small_car", "sedan", "estate", "suv", "van")}
        try:
            for made, make in makers.items():
                setattr(car_proportions, made, _bowed(make, FLANKS_M[name], flat_ends="ends" in name))
            out = folder.with_name(f"{folder.name}-run")
            interface.run(
                SCENARIO,
                tracker=NoTracks,
                duration_s=DURATION_S,
                out=out,
                dataset_to=folder,
                ahead=False,
                progress=True,
            )
        finally:
            for made, make in makers.items():
                setattr(car_proportions, made, make)
    return [one for one in labelled_vehicle.read(folder, 0, 0.0, 0) if one.frame % EVERY == 0]


def _bowed(
    make: Callable[[Draw], CarProportions], side_bow: float, *, flat_ends: bool
) -> Callable[[Draw], CarProportions]:
    ends = {"front_bow": Bow(0.0, 0.0, 0.0, 0.0), "rear_bow": Bow(0.0, 0.0, 0.0, 0.0)} if flat_ends else {}
    return lambda draw: replace(make(draw), side_bow=side_bow, **ends)


TOUCHED_M = 0.3
"""Points further from the sides of the box do not count for the view [m]."""


def view(vehicle: LabelledVehicle) -> str:
    """Return which faces have at least three points over half of an end, or over 1 m of a flank."""
    seen = set()
    for face in visible_faces(vehicle):
        half = 0.5 * vehicle.box[4 if face.end else 3]
        along = face.along[(np.abs(face.depth) < TOUCHED_M) & (np.abs(face.along) < half - 0.2)]
        if len(along) >= 3 and np.ptp(along) > (0.5 if face.end else 1.0):
            seen.add(face.end)
    return {(): "none", (False,): "side", (True,): "end", (False, True): "L-shape"}[tuple(sorted(seen))]


def across(vehicles: Sequence[LabelledVehicle]) -> npt.NDArray[np.bool_]:
    """Mask the vehicles whose dominant line, the one with most points, lies across them: on an end."""
    config, sizes = papers_steps(), [len(vehicle.line) for vehicle in vehicles]
    points, lines = (np.concatenate([getattr(one, name) for one in vehicles]) for name in ("points_ego", "line"))
    segments = Segments(np.repeat(np.arange(len(sizes)), sizes), len(sizes))
    linkage = tlinkage.link(
        segmentation.sort_by_segment(points, segments, scan_line=lines), config.linkage, config.lidar
    )
    found = []
    for vehicle, line in zip(vehicles, np.split(linkage.line, np.cumsum(sizes)[:-1]), strict=True):
        ahead, left = np.linalg.eigh(np.cov(vehicle.points_box[line == 0].T))[1][:, 1]
        found.append(abs(left) > abs(ahead))
    return np.array(found)


def errors(vehicles: Sequence[LabelledVehicle], config: DetectorConfig) -> Floats:
    """Return the absolute heading error of the selected rectangle of each vehicle [deg]."""
    return np.abs(labelled_fits.fit(vehicles, config).error_deg["best"])


def table(sets: dict[str, list[LabelledVehicle]]) -> str:
    """Return mean absolute errors of the selected rectangle, a column per set."""
    base = {name: errors(vehicles, papers_steps()) for name, vehicles in sets.items()}
    rows: list[tuple[object, ...]] = [("observations", *(len(of) for of in base.values()))]
    rows += [(name, *(_mean(errors(some, config)) for some in sets.values())) for name, config in CHANGES.items()]
    views = {name: np.array([view(one) for one in vehicles]) for name, vehicles in sets.items()}
    for wanted in ("L-shape", "side", "end"):
        rows.append((f"{wanted} only", *(_part(base[name], views[name] == wanted) for name in sets)))
    ends = {name: across(vehicles) for name, vehicles in sets.items()}
    for face, is_end in (("flank", False), ("end", True)):
        of_face = (_part(base[name], (views[name] == "L-shape") & (ends[name] == is_end)) for name in sets)
        rows.append((f"L-shape, dominant line on the {face}", *of_face))
    for low, high in RANGES_M:
        rows.append((f"{low} to {high} m", *(_part(base[name], _within(sets[name], low, high)) for name in sets)))
    rows.append(("median", *(f"{np.median(of):.2f}" for of in base.values())))
    rows.append(("above 5 degrees", *(f"{100 * np.mean(of > 5.0):.0f} %" for of in base.values())))
    return markdown(("mean absolute error of `best` [deg]", *sets), rows)


def _mean(error: Floats) -> str:
    return f"{error.mean():.2f}"


def _part(error: Floats, mask: npt.NDArray[np.bool_]) -> str:
    return f"{error[mask].mean():.2f} (n = {mask.sum()})" if mask.any() else ""


def _within(vehicles: Sequence[LabelledVehicle], low: float, high: float) -> npt.NDArray[np.bool_]:
    return np.array([low <= one.range_m < high for one in vehicles])


def draw(sets: dict[str, list[LabelledVehicle]]) -> None:
    """Draw the errors of the paper's steps and with another rule for outliers, by range."""
    shown = {"the paper's steps": papers_steps(), "its outliers by two perpendicular faces": papers_steps("faces")}
    with matplotlib.rc_context(STYLE):
        canvas = Figure(figsize=(9.6, 3.6), layout="constrained", facecolor=PAPER)
        for axes, (title, config) in zip(canvas.subplots(1, 2, sharey=True), shown.items(), strict=True):
            for name, vehicles in sets.items():
                error = errors(vehicles, config)
                means = [error[_within(vehicles, low, high)].mean() for low, high in RANGES_M]
                real = name.startswith("real")
                axes.plot(range(len(means)), means, "ks--" if real else "o-", label=name)
            published = HEADING_ABS_DEG["best"][0]
            axes.axhline(published, color="0.5", ls=":", label=f"the paper: {published:.2f}")
            axes.set_xticks(range(len(RANGES_M)), [f"{low} to {high} m" for low, high in RANGES_M])
            axes.set_title(title)
            axes.set_ylim(bottom=0.0)
        axes.legend()
        canvas.supylabel("mean |heading error| of best selection [deg]")
        canvas.savefig(PICTURE, dpi=PIXELS_PER_INCH, metadata={"Software": None})
