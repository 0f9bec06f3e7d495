"""Cost of a frame: tables and picture from the rows of `make bench`."""

import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from blocks import commands
from blocks.markdown import markdown
from matplotlib.axes import Axes

PICTURE = Path(__file__).parents[1] / "pictures" / "performance.png"
VEHICLES, UNITS = (10, 25, 50, 100), (1, 2, 4, 6)
STAGES = {"sensor": "#4878a8", "tracker": "#d98032", "grading": "#6a9f58", "traffic": "#888888"}
SCALED = ("sensor", "tracker", "grading")

Rows = Mapping[str, Mapping[str, Any]]


@cache
def rows() -> Rows:
    """Return the rows of the benchmark, by name."""
    commands.output("make bench")
    found: Rows = json.loads((commands.ROOT / "benchmarks" / "latest.json").read_text(encoding="utf-8"))
    return found


def stages(_name: str) -> str:
    """Return the table of the stages of the loop."""
    cost = [(stage, rows()[f"loop.{stage}_ms_30veh"]) for stage in STAGES]
    total, multiple = (sum(row[key] for _, row in cost) for key in ("value", "multiple"))
    cells = [
        (stage, f"{row['value']:.1f}", f"{row['multiple']:.1f}", f"{row['value'] / total:.0%}") for stage, row in cost
    ]
    return markdown(
        ("stage", "ms", "times the reference", "share"), [*cells, ("all", f"{total:.1f}", f"{multiple:.1f}", "100%")]
    )


def scaling(_name: str) -> str:
    """Return the table of the cost against vehicles and LIDARs."""
    runs = [(f"{count}veh", f"{count} vehicles") for count in VEHICLES]
    runs += [(f"{count}units", f"{count} LIDAR{'s' if count > 1 else ''}") for count in UNITS]
    cells = []
    for end, label in runs:
        cost = [rows()[f"scaling.{stage}_ms_{end}"] for stage in SCALED]
        points = cost[0]["peer"].removesuffix(" points a scan")
        cells.append((label, points, *(f"{row['value']:.1f}" for row in cost)))
    return markdown(("", "points", *(f"{stage} [ms]" for stage in SCALED)), cells)


def picture(_name: str) -> None:
    """Draw the stages of a frame, and their cost against vehicles and LIDARs."""
    figure, (whole, by_vehicles, by_units) = plt.subplots(1, 3, figsize=(11, 3.6), layout="constrained")
    ms = {stage: rows()[f"loop.{stage}_ms_30veh"]["value"] for stage in STAGES}
    whole.barh(list(ms), list(ms.values()), color=list(STAGES.values()))
    whole.invert_yaxis()
    whole.bar_label(whole.containers[0], fmt="%.1f ms", padding=3)
    whole.set(xlabel="ms per frame", title="SUMO crossing, 30 vehicles or more", xlim=(0, 1.3 * max(ms.values())))
    _draw_growth(by_vehicles, VEHICLES, "veh", "vehicles within 80 m, six LIDARs")
    _draw_growth(by_units, UNITS, "units", "LIDARs, 50 vehicles")
    by_units.legend(frameon=False)
    for axes in figure.axes:
        axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(PICTURE, dpi=110)


def _draw_growth(axes: Axes, counts: tuple[int, ...], end: str, label: str) -> None:
    for stage in SCALED:
        ms = [rows()[f"scaling.{stage}_ms_{count}{end}"]["value"] for count in counts]
        axes.plot(counts, ms, "o-", color=STAGES[stage], label=stage)
    axes.set(xlabel=label, ylabel="ms per frame", xlim=(0, None), ylim=(0, None))
