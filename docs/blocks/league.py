"""Standings and picture of a league."""

import json
import shutil
from pathlib import Path
from typing import Any

from blocks import commands

PICTURE = Path(__file__).parents[1] / "pictures" / "league.png"
OUT = commands.RUNS / "league"


def tables(_name: str) -> str:
    """Return the answer and the standings."""
    found = result()
    return f"{summary(found)}\n\n{standings(found)}"


def picture(_name: str) -> None:
    """Copy the picture of the standings."""
    result()
    shutil.copyfile(OUT / "hota.png", PICTURE)


def result() -> dict[str, Any]:
    """Return the league's result; finished runs are taken up."""
    commands.output(f"luxloop league --out {OUT.relative_to(commands.ROOT)}")
    found: dict[str, Any] = json.loads((OUT / "league.json").read_text(encoding="utf-8"))
    return found


def summary(found: dict[str, Any]) -> str:
    """Return the size of the league and its result in a paragraph."""
    seeds = ", ".join(map(str, found["seeds"]))
    size = f"{len(found['scenarios'])} scenarios, seeds {seeds}, {found['duration_max_s']:g} s each"
    runs = f"{len(found['rows'])} runs: {size}"
    return f"{runs}. {found['answer']}."


def standings(found: dict[str, Any]) -> str:
    """Return the table of all trackers."""
    lines = ["| tracker | HOTA | 95 % | id switches | GOSPA [m] | false | missed | step time | runs, failed |",
             "|---|---|---|---|---|---|---|---|---|"]  # fmt: skip
    for each in found["standings"]:
        low, high = each["hota_interval"]
        counts = each["counts"]
        cells = [
            each["tracker"], number(each["hota"]), f"{number(low)} to {number(high)}", counts["id_switches"],
            number(each["gospa_m"]), counts["false"], counts["missed"], f"{each['step_ratio']:.1f}",
            f"{each['runs']}, {each['failed']}",
        ]  # fmt: skip
        lines.append(f"| {' | '.join(map(str, cells))} |")
    return "\n".join(lines)


def number(value: float | None) -> str:
    """Return a figure with three decimals."""
    return "n/a" if value is None else f"{value:.3f}"
