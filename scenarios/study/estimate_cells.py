"""Cells of the table beneath a curve: the figure, its interval, and what its kind has beside it."""

from typing import Any, Literal

import pandas as pd

from luxloop.scenarios.statistics.confidence import FEWEST_SEEDS
from luxloop.scenarios.study.seed_estimate import is_binary

Kind = Literal["share", "count", "quantity"]


def kind_of(rows: pd.DataFrame, metric: str, unit: str) -> Kind:
    """Return the kind of a metric: a share of runs, a count, or any other quantity."""
    if is_binary(rows[metric]):
        return "share"
    return "count" if unit == "count" else "quantity"


def estimate_head(kind: Kind) -> list[str]:
    """Return the names of the columns."""
    if kind == "share":
        return ["share", "95 %", "runs"]
    return ["median", "95 %", "mean", *(["seeds with any", "95 %"] if kind == "count" else []), "runs"]


def estimate_cells(row: dict[str, Any], kind: Kind) -> list[str]:
    """Return the cells of the fields of an `Estimate`."""
    known = row["n"] > 0
    cells = interval_cells(row)
    if kind != "share":
        cells.append(f"{row['mean']:.3g}" if known else "-")
    if kind == "count":
        cells += [f"{row['share_any']:.0%}", _any(row)] if known else ["-", ""]
    return [*cells, f"{row['n']:g}" if row["n"] == row["runs"] else f"{row['n']:g} of {row['runs']:g}"]


def interval_cells(row: dict[str, Any]) -> list[str]:
    """Return the figure and its interval."""
    if not row["n"]:
        return ["-", ""]
    has_interval = row["low"] == row["low"]
    ends = f"{row['low']:.3g} to {row['high']:.3g}" if has_interval else f"fewer than {FEWEST_SEEDS} seeds"
    return [f"{row['value']:.3g}", ends]


def _any(row: dict[str, Any]) -> str:
    """Return the interval of the share of seeds with a value other than 0, in percent."""
    if row["share_any"] == 0.0:
        return f"at most {row['any_high']:.0%}"
    return f"{row['any_low']:.0%} to {row['any_high']:.0%}"
