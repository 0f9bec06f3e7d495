"""Tables and pictures of the comparison of simulated vehicles with tables of real ones.

The tables of real vehicles are `REAL_DATA/realism/NAME.csv` and `NAME-bow.csv`, made as docs/realism.md describes.
"""

import json
import shutil
from functools import cache
from pathlib import Path
from typing import Any

from blocks import commands

from luxloop.scenarios.realism.compared_figures import FIGURES, Figure, bow_figure

PICTURES = Path(__file__).parents[1] / "pictures"
EXAMPLES = Path(__file__).parents[1] / "examples"
DRAWN = "bumper-89"
SHOWN = ("bow", "distributions", "vehicles")
"""Pictures of the page, of the table `DRAWN`."""
BY_NAME = {figure.name: figure for figure in FIGURES}

Json = dict[str, Any]


@cache
def compared(name: str) -> Path:
    """Return the folder of `luxloop realism` with a table of real vehicles, such as `roof-55`."""
    real, view, out = commands.real("realism"), name.partition("-")[0], commands.RUNS / f"realism-{name}"
    sets = []
    for kind in ("car", "suv"):
        sets.append(str(commands.RUNS / f"{view}-{kind}"))
        commands.output(f"luxloop run {EXAMPLES / view / f'{view}-{kind}.toml'} --no-recording --dataset {sets[-1]}")
    bands = f"--real-bands {real / name}-bow.csv" if Path(f"{real / name}-bow.csv").is_file() else ""
    commands.output(f"luxloop realism {' '.join(sets)} --real {real / name}.csv {bands} --out {out}")
    return out


def block(name: str) -> str:
    """Return the table of a block, with its figures."""
    return table(json.loads((compared(name) / "realism.json").read_text(encoding="utf-8"))["figures"])


def picture(name: str) -> None:
    """Copy a picture such as `realism_bow`."""
    shutil.copyfile(compared(DRAWN) / f"{name.removeprefix('realism_')}.png", PICTURES / f"{name}.png")


def table(figures: Json) -> str:
    """Return the Markdown table of figures, with the number that agree."""
    lines = ["| figure | real (quartiles) | simulated [95 %] | verdict |", "|---|---|---|---|"]
    for name, entry in figures.items():
        figure = BY_NAME.get(name) or _band(name)
        unit = "" if figure.unit == "1" else f" [{figure.unit}]"
        cells = [f"{figure.label}{unit}", _real(entry, figure), _simulated(entry, figure), entry["verdict"]]
        lines.append(f"| {' | '.join(cells)} |")
    judged = [f for f in figures.values() if f["verdict"] != "n/a"]
    lines.append(f"| **agree** | | {sum(f['verdict'] == 'agrees' for f in judged)} of {len(judged)} | |")
    return "\n".join(lines)


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
