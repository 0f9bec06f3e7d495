"""Cost of each stage of the tracker by its oracle, and the ceiling of HOTA."""

import json
from typing import Any

from blocks import commands
from blocks.markdown import markdown

SHOWN = {
    "track.hota": "HOTA", "track.idf1": "IDF1", "fit.heading_abs_mean_deg": "heading of fits [deg]",
    "track.time_to_confirm_s": "confirmed after [s]", "track.missed": "missed", "track.false": "false",
    "track.id_switches": "id switches", "track.occlusion_survival": "survival",
}  # fmt: skip
"""Columns of the table by their metrics."""


def blame(_name: str) -> str:
    """Return a row per stage: its cost in HOTA, and the metrics with the truth in its place."""
    found = json.loads(commands.output("luxloop blame sumo-crossing --json"))
    rows = [("none", "", "", *figures(found["shipped"]))]
    for stage, cost in found["costs"]["track.hota"].items():
        interval = " to ".join(f"{end:.3f}" for end in cost["interval"] or ())
        rows.append((stage, f"{cost['value']:.3f}", interval, *figures(found["by_truth"][stage])))
    return markdown(("truth for", "cost in HOTA", "95 %", *SHOWN.values()), rows)


def figures(metrics: dict[str, Any]) -> list[str]:
    """Return the values of the columns."""
    values = [metrics[name]["value"] for name in SHOWN]
    return ["n/a" if value is None else f"{value:.3f}".removesuffix(".000") for value in values]


def ceiling(_name: str) -> str:
    """Return the table that the command prints."""
    return f"```text\n{commands.output('luxloop ceiling sumo-crossing --seeds 11-13').strip()}\n```"
