"""Cost of a frame: tables from the rows of `make bench`."""

import json
from functools import cache
from typing import Any

from blocks import commands
from blocks.markdown import markdown

RUNS = {f"{count}veh": f"{count} vehicles" for count in (10, 25, 50, 100)}
RUNS |= {f"{count}units": f"{count} LIDAR{'s' if count > 1 else ''}" for count in (1, 2, 4, 6)}
STAGES = ("sensor", "tracker", "grading", "traffic")
SCALED = STAGES[:3]


@cache
def rows() -> dict[str, Any]:
    """Return the rows of the benchmark, by name."""
    commands.output("make bench")
    found: dict[str, Any] = json.loads((commands.ROOT / "benchmarks" / "latest.json").read_text(encoding="utf-8"))
    return found


def stages(_name: str) -> str:
    """Return the table of the stages of the loop."""
    cost = {stage: rows()[f"loop.{stage}_ms_30veh"] for stage in STAGES}
    cost["all"] = {key: sum(row[key] for row in cost.values()) for key in ("value", "multiple")}
    total = cost["all"]["value"]
    cells = (
        (stage, f"{row['value']:.1f}", f"{row['multiple']:.1f}", f"{row['value'] / total:.0%}")
        for stage, row in cost.items()
    )
    return markdown(("stage", "ms", "times the reference", "share"), cells)


def scaling(_name: str) -> str:
    """Return the table of the cost against vehicles and LIDARs."""
    cells = []
    for end, label in RUNS.items():
        cost = [rows()[f"scaling.{stage}_ms_{end}"] for stage in SCALED]
        points = cost[0]["peer"].removesuffix(" points a scan")
        cells.append((label, points, *(f"{row['value']:.1f}" for row in cost)))
    return markdown(("", "points", *(f"{stage} [ms]" for stage in SCALED)), cells)
