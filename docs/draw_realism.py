"""Write a result of realism.md: one of its tables, and the pictures in docs/pictures with the table that is drawn.

luxloop realism bumper-car bumper-suv --real real_cars.csv --real-bands real_bow.csv --out after
python docs/draw_realism.py bumper-89 after before

The first argument is the name of the table of real vehicles, one of `TABLES`. `before` is the same comparison of an
earlier version; without it, the table has no such column.
"""

import json
import shutil
import sys
from pathlib import Path
from typing import Any

from marked_text import replace

from luxloop.scenarios.realism.realism_comparison import FIGURES, Figure, bow_figure

DOCS = Path(__file__).parent
PAGE, PICTURES = DOCS / "realism.md", DOCS / "pictures"
DRAWN = "bumper-89"
TABLES = ("roof-55", "roof-54", DRAWN)
"""Names of the tables in the page, by place of the LIDAR and number of vehicles; the last one is drawn, too."""
AFTER, BEFORE = "after", "before"
SHOWN = ("bow", "distributions", "vehicles")
"""Pictures of the page."""
BY_NAME = {figure.name: figure for figure in FIGURES}

Json = dict[str, Any]


def main() -> None:
    """Copy the pictures and replace the table."""
    name, *given = sys.argv[1:4]
    if name not in TABLES:
        sys.exit(f"{name}: no such table; give one of {', '.join(TABLES)}")
    folders = dict(zip((AFTER, BEFORE), map(Path, given), strict=False))
    if name == DRAWN:
        for picture in SHOWN:
            shutil.copyfile(folders[AFTER] / f"{picture}.png", PICTURES / f"realism_{picture}.png")
    documents = {side: json.loads((folder / "realism.json").read_text()) for side, folder in folders.items()}
    replace(PAGE, name, table(documents))


def table(documents: dict[str, Json]) -> str:
    """Return the Markdown table of the figures, before and after, with the number that agree."""
    sides = [side for side in (BEFORE, AFTER) if side in documents]
    figures = {side: documents[side]["figures"] for side in sides}
    headings = [f"simulated {side} [95 %]" for side in sides] if len(sides) > 1 else ["simulated [95 %]"]
    lines = [
        f"| figure | real (quartiles) | {' | '.join(headings)} | verdict |",
        f"|---|---|{'---|' * len(sides)}---|",
    ]
    for name, entry in figures[AFTER].items():
        figure = BY_NAME.get(name) or _band(name)
        simulated = [_simulated(figures[side].get(name), figure) for side in sides]
        unit = "" if figure.unit == "1" else f" [{figure.unit}]"
        cells = [f"{figure.label}{unit}", _real(entry, figure), *simulated, entry["verdict"]]
        lines.append(f"| {' | '.join(cells)} |")
    judged = {side: [f for f in figures[side].values() if f["verdict"] != "n/a"] for side in sides}
    agree = [f"{sum(f['verdict'] == 'agrees' for f in judged[side])} of {len(judged[side])}" for side in sides]
    lines.append(f"| **agree** | | {' | '.join(agree)} | |")
    return "\n".join(lines)


def _band(name: str) -> Figure:
    """Return the figure of a height band, from its column such as bow_end_0.45_0.75_m."""
    _, face, low, high, _ = name.split("_")
    return bow_figure(name, f"bow {face} {low} to {high} m")


def _real(entry: Json, figure: Figure) -> str:
    low, high = (figure.scale * end for end in entry["real"]["quartiles"])
    return f"{figure.scale * entry['real']['value']:.{figure.digits}f} ({low:.1f} to {high:.1f})"


def _simulated(entry: Json | None, figure: Figure) -> str:
    if entry is None or entry["simulated"] is None:
        return "n/a"
    value, interval = entry["simulated"]["value"], entry["simulated"]["interval"]
    ends = f" [{', '.join(f'{figure.scale * end:.1f}' for end in interval)}]" if interval else ""
    return f"{figure.scale * value:.{figure.digits}f}{ends}"


if __name__ == "__main__":
    main()
