"""Cost of a frame: tables and picture from the rows of `make bench`."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
from blocks import commands
from matplotlib.axes import Axes

PICTURE = Path(__file__).parents[1] / "pictures" / "performance.png"
VEHICLES, UNITS = (10, 25, 50, 100), (1, 2, 4, 6)
STAGES = {"sensor": "#4878a8", "tracker": "#d98032", "grading": "#6a9f58", "traffic": "#888888"}
SCALED = ("sensor", "tracker", "grading")

Rows = Mapping[str, Mapping[str, Any]]


def rows() -> Rows:
    """Return the rows of the benchmark, by name."""
    commands.output("make bench")
    found: Rows = json.loads((commands.ROOT / "benchmarks" / "latest.json").read_text(encoding="utf-8"))
    return found


def table(name: str) -> str:
    """Return the table of the stages, or that of the growth with vehicles and LIDARs."""
    return stage_table(rows()) if name == "stages" else scaling_table(rows())


def picture(_name: str) -> None:
    """Draw the picture."""
    draw(rows())


def draw(rows: Rows) -> None:
    """Draw the stages of a frame, and their cost against vehicles and LIDARs."""
    figure, (whole, by_vehicles, by_units) = plt.subplots(1, 3, figsize=(11, 3.6), layout="constrained")
    _draw_stages(whole, rows)
    _draw_law(by_vehicles, rows, VEHICLES, "veh", "vehicles within 80 m, six LIDARs")
    _draw_law(by_units, rows, UNITS, "units", "LIDARs, 50 vehicles")
    by_units.legend(frameon=False)
    figure.savefig(PICTURE, dpi=110)


def _draw_stages(axes: Axes, rows: Rows) -> None:
    ms = {stage: rows[f"loop.{stage}_ms_30veh"]["value"] for stage in STAGES}
    axes.barh(list(ms), list(ms.values()), color=list(STAGES.values()))
    axes.invert_yaxis()
    axes.bar_label(axes.containers[0], fmt="%.1f ms", padding=3)
    axes.set(xlabel="ms per frame", title="SUMO crossing, 30 vehicles or more", xlim=(0, 1.3 * max(ms.values())))
    axes.spines[["top", "right"]].set_visible(False)


def _draw_law(axes: Axes, rows: Rows, counts: tuple[int, ...], end: str, label: str) -> None:
    for stage in SCALED:
        ms = [rows[f"scaling.{stage}_ms_{count}{end}"]["value"] for count in counts]
        axes.plot(counts, ms, "o-", color=STAGES[stage], label=stage)
    axes.set(xlabel=label, ylabel="ms per frame", xlim=(0, None), ylim=(0, None))
    axes.spines[["top", "right"]].set_visible(False)


def stage_table(rows: Rows) -> str:
    """Return the Markdown table of the stages of the loop."""
    ms = {stage: rows[f"loop.{stage}_ms_30veh"] for stage in STAGES}
    total = sum(row["value"] for row in ms.values())
    lines = ["| stage | ms | times the reference | share |", "|---|---|---|---|"]
    for stage, row in ms.items():
        lines.append(f"| {stage} | {row['value']:.1f} | {row['multiple']:.1f} | {row['value'] / total:.0%} |")
    lines.append(f"| all | {total:.1f} | {sum(row['multiple'] for row in ms.values()):.1f} | 100% |")
    return "\n".join(lines)


def scaling_table(rows: Rows) -> str:
    """Return the Markdown table of the cost against vehicles and LIDARs."""
    lines = [f"| | points | {' | '.join(f'{stage} [ms]' for stage in SCALED)} |", f"|---|---|{'---|' * len(SCALED)}"]
    runs = [(f"{count}veh", f"{count} vehicles") for count in VEHICLES]
    runs += [(f"{count}units", f"{count} LIDAR{'s' if count > 1 else ''}") for count in UNITS]
    for end, label in runs:
        cells = [rows[f"scaling.{stage}_ms_{end}"] for stage in SCALED]
        points = cells[0]["peer"].removesuffix(" points a scan")
        figures = " | ".join(f"{cell['value']:.1f}" for cell in cells)
        lines.append(f"| {label} | {points} | {figures} |")
    return "\n".join(lines)
