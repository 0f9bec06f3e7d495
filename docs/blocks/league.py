"""Standings and picture of a league."""

import json
import shutil
from functools import cache
from pathlib import Path
from typing import Any

from blocks import commands
from blocks.markdown import markdown

PICTURE = Path(__file__).parents[1] / "pictures" / "league.png"
OUT = commands.RUNS / "league"
HEAD = ("tracker", "HOTA", "95 %", "id switches", "GOSPA [m]", "false", "missed", "step time", "runs, failed")


@cache
def result() -> dict[str, Any]:
    """Return the league's result; finished runs are taken up."""
    commands.output(f"luxloop league --out {OUT.relative_to(commands.ROOT)}")
    found: dict[str, Any] = json.loads((OUT / "league.json").read_text(encoding="utf-8"))
    return found


def tables(_name: str) -> str:
    """Return the answer and the standings."""
    found = result()
    seeds = ", ".join(map(str, found["seeds"]))
    size = f"{len(found['scenarios'])} scenarios, seeds {seeds}, {found['duration_max_s']:g} s each"
    standings = markdown(HEAD, map(cells, found["standings"]))
    return f"{len(found['rows'])} runs: {size}. {found['answer']}.\n\n{standings}"


def picture(_name: str) -> None:
    """Copy the picture of the standings."""
    result()
    shutil.copyfile(OUT / "hota.png", PICTURE)


def cells(each: dict[str, Any]) -> tuple[object, ...]:
    """Return the row of a tracker."""
    interval, counts = " to ".join(map(number, each["hota_interval"])), each["counts"]
    return (
        each["tracker"], number(each["hota"]), interval, counts["id_switches"], number(each["gospa_m"]),
        counts["false"], counts["missed"], f"{each['step_ratio']:.1f}", f"{each['runs']}, {each['failed']}",
    )  # fmt: skip


def number(value: float | None) -> str:
    """Return a figure with three decimals."""
    return "n/a" if value is None else f"{value:.3f}"
