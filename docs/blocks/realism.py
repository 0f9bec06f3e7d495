"""Tables and pictures of the comparison of simulated vehicles with those of a labelled street."""

import shutil
import tempfile
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import pandas as pd
from blocks import commands, stamps
from blocks.markdown import markdown

from luxloop.scenarios.realism import fit_observations, labelled_vehicle, realism_figures
from luxloop.scenarios.realism.labelled_vehicle import POINTS_MIN, LabelledVehicle
from luxloop.scenarios.realism.real_table import BANDS
from luxloop.scenarios.realism.realism_comparison import ComparedRow, Comparison, Figure, Summary, compare
from luxloop.scenarios.realism.vehicle_figures import keys, measure

PICTURES = Path(__file__).parents[1] / "pictures"
EXAMPLES = Path(__file__).parents[1] / "examples" / "bumper"
SHOWN = ("distributions", "vehicles")
"""Pictures of the page."""
LABEL_SIGMA_DEG = 1.5
"""Error of the labels' headings, added to the simulated ones, as by `luxloop realism`."""


def street() -> list[LabelledVehicle]:
    """Return the vehicles of 3.8 s of PandaSet's scene 002, cut to four layers at bumper height."""
    folder = commands.real("street")
    found = fit_observations.read(folder, folder / "bumper_points.parquet", 0)
    return [one for one in found if len(one.line) >= POINTS_MIN and one.seen_from_outside]


def simulated(scenario: str) -> Path:
    """Return the data set of a scenario, which is simulated once in each version of the runs."""
    out = commands.RUNS / f"{Path(scenario).stem}-set-{stamps.runs((stamps.CATALOG,))[-8:]}"
    if not out.is_dir():
        commands.output(f"luxloop run {scenario} --no-recording --dataset {out}")
    return out


def against(real: Sequence[LabelledVehicle], vehicles: Sequence[LabelledVehicle]) -> Comparison:
    """Return the comparison of simulated vehicles with real ones, as by `luxloop realism`."""
    measured = pd.concat([keys(real), measure(real)], axis=1)
    return compare(measured, pd.DataFrame(columns=pd.Index(BANDS)), vehicles)


@cache
def compared() -> Comparison:
    """Return the comparison with the street."""
    folders = [simulated(f"{EXAMPLES}/bumper-{kind}.toml") for kind in ("car", "suv")]
    found = (labelled_vehicle.read(folder, number, LABEL_SIGMA_DEG, 0) for number, folder in enumerate(folders))
    return against(street(), [vehicle for vehicles in found for vehicle in vehicles])


def block(_name: str) -> str:
    """Return the table of the figures."""
    return table(compared().rows)


def picture(name: str) -> None:
    """Write a picture such as `realism_vehicles`."""
    with tempfile.TemporaryDirectory() as folder:
        realism_figures.save(compared(), Path(folder))
        shutil.copyfile(Path(folder) / f"{name.removeprefix('realism_')}.png", PICTURES / f"{name}.png")


def table(compared_rows: Sequence[ComparedRow]) -> str:
    """Return the Markdown table of figures, with the number that agree."""
    rows = []
    for row in compared_rows:
        unit = "" if row.figure.unit == "1" else f" [{row.figure.unit}]"
        sides = (_shown(row.figure, row.real, quartiles=True), _shown(row.figure, row.simulated, quartiles=False))
        rows.append((f"{row.figure.label}{unit}", *sides, row.verdict))
    verdicts = [verdict for *_, verdict in rows if verdict != "n/a"]
    rows.append(("**agree**", "", f"{verdicts.count('agrees')} of {len(verdicts)}", ""))
    return markdown(("figure", "real (quartiles)", "simulated [95 %]", "verdict"), rows)


def _shown(figure: Figure, summary: Summary | None, *, quartiles: bool) -> str:
    if summary is None:
        return "n/a"
    ends = [f"{figure.scale * end:.1f}" for end in (summary.quartiles if quartiles else summary.interval) or ()]
    limits = f" ({' to '.join(ends)})" if quartiles else f" [{', '.join(ends)}]" if ends else ""
    return f"{figure.scale * summary.value:.{figure.digits}f}{limits}"
