"""Table of the candidates for the ego."""

from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from luxloop.sim.candidates.candidates import Candidates
from luxloop.sim.candidates.want import Want

UNITS = {
    "enters_s": "s", "stay_s": "s", "distance_m": "m", "neighbours": "1", "near": "1", "turns": "1", "stops": "count",
    "occlusion": "1",
}  # fmt: skip
"""Columns with units."""
WANTED_COLUMN = {
    Want.NEIGHBOURS: "near", Want.TURNS: "turns", Want.STOPS: "stops", Want.OCCLUSION: "occlusion", Want.LONG: "stay_s"
}  # fmt: skip


def table(found: Candidates, rows: list[int], want: Want, ranges: tuple[float, float]) -> RenderableType:
    """Return the table of some candidates, in this order.

    Parameters
    ----------
    found, rows
        Candidates, and those that are shown.
    want
        What they are ordered by.
    ranges
        Sensor range and range of grading [m].
    """
    shown = Table(box=None, padding=(0, 2, 0, 0), header_style="bold")
    heads = {
        "ego": "vehicle", "class": "class", "enters_s": "enters [s]", "stay_s": "stays [s]", "distance_m": "drives [m]",
        "neighbours": f"in {ranges[0]:g} m", "near": f"in {ranges[1]:g} m", "turns": "turns [%]", "stops": "stops",
        "occlusion": "occluded [%]", "suitable": "ego?",
    }  # fmt: skip
    for name, head in heads.items():
        text = name in ("ego", "class", "suitable")
        style = "bold" if name in (WANTED_COLUMN[want], "ego") else ""
        word = max(map(len, head.split()))  # rich would cut it where the table is narrow
        shown.add_column(head, justify="left" if text else "right", style=style, no_wrap=text, min_width=word)
    for row in rows:
        shown.add_row(*_cells(document(found, row)))
    note = (
        "Other vehicles are counted in two ranges. + after a stay: still there at the end of the survey. "
        "Occluded: share of near vehicles behind another one, seen from above."
    )
    return Group(shown, Text(f"\n{note}", style="dim"))


def document(found: Candidates, row: int) -> dict[str, Any]:
    """Return a candidate for `--json`."""
    body = found.bodies[row]
    figures = {name: round(float(getattr(found, name)[row]), 3) for name in UNITS}
    return {
        "ego": body.name,
        "class": body.vehicle_class,
        "suitable": not body.rejected,
        **figures,
        "stops": int(found.stops[row]),
        "leaves": bool(found.leaves[row]),
    }


def _cells(entry: dict[str, Any]) -> list[str]:
    more = "" if entry["leaves"] else "+"
    return [
        entry["ego"],
        entry["class"],
        f"{entry['enters_s']:.0f}",
        f"{entry['stay_s']:.0f}{more}",
        f"{entry['distance_m']:.0f}",
        f"{entry['neighbours']:.1f}",
        f"{entry['near']:.1f}",
        f"{100 * entry['turns']:.0f}",
        f"{entry['stops']}",
        f"{100 * entry['occlusion']:.0f}",
        "yes" if entry["suitable"] else "no",
    ]
