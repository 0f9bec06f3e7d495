"""Tables and pictures of the comparison of simulated vehicles with those of a labelled street."""

import json
import shutil
from functools import cache
from pathlib import Path
from typing import Any

import pandas as pd
from blocks import commands, stamps
from blocks.markdown import markdown

from luxloop.scenarios.realism import fit_observations, vehicle_figures
from luxloop.scenarios.realism.labelled_vehicle import POINTS_MIN, LabelledVehicle
from luxloop.scenarios.realism.realism_comparison import FIGURES, Figure, bow_figure

PICTURES = Path(__file__).parents[1] / "pictures"
EXAMPLES = Path(__file__).parents[1] / "examples" / "bumper"
SHOWN = ("distributions", "vehicles")
"""Pictures of the page."""
BY_NAME = {figure.name: figure for figure in FIGURES}

Json = dict[str, Any]


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


@cache
def compared() -> Path:
    """Return the folder of `luxloop realism`, with the street as the table of real vehicles."""
    real, out = commands.RUNS / "realism-street.csv", commands.RUNS / "realism-street"
    vehicles = street()
    pd.concat([vehicle_figures.keys(vehicles), vehicle_figures.measure(vehicles)], axis=1).to_csv(real, index=False)
    sets = " ".join(str(simulated(f"{EXAMPLES}/bumper-{kind}.toml")) for kind in ("car", "suv"))
    commands.output(f"luxloop realism {sets} --real {real} --out {out}")
    return out


def block(_name: str) -> str:
    """Return the table of the figures."""
    return table(json.loads((compared() / "realism.json").read_text(encoding="utf-8"))["figures"])


def picture(name: str) -> None:
    """Copy a picture such as `realism_vehicles`."""
    shutil.copyfile(compared() / f"{name.removeprefix('realism_')}.png", PICTURES / f"{name}.png")


def table(figures: Json) -> str:
    """Return the Markdown table of figures, with the number that agree."""
    rows = []
    for name, entry in figures.items():
        figure = BY_NAME.get(name) or _band(name)
        unit = "" if figure.unit == "1" else f" [{figure.unit}]"
        rows.append((f"{figure.label}{unit}", _real(entry, figure), _simulated(entry, figure), entry["verdict"]))
    verdicts = [verdict for *_, verdict in rows if verdict != "n/a"]
    rows.append(("**agree**", "", f"{verdicts.count('agrees')} of {len(verdicts)}", ""))
    return markdown(("figure", "real (quartiles)", "simulated [95 %]", "verdict"), rows)


def _band(name: str) -> Figure:
    """Return the figure of a height band, from its column such as bow_end_0.45_0.75_m."""
    _, face, low, high, _ = name.split("_")
    return bow_figure(name, f"bow {face} {low} to {high} m")


def _real(entry: Json, figure: Figure) -> str:
    low, high = (figure.scale * end for end in entry["real"]["quartiles"])
    return f"{figure.scale * entry['real']['value']:.{figure.digits}f} ({low:.1f} to {high:.1f})"


def _simulated(entry: Json, figure: Figure) -> str:
    if entry["simulated"] is None:
        return "n/a"
    value, interval = entry["simulated"]["value"], entry["simulated"]["interval"]
    ends = f" [{', '.join(f'{figure.scale * end:.1f}' for end in interval)}]" if interval else ""
    return f"{figure.scale * value:.{figure.digits}f}{ends}"
