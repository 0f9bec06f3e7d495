"""Runs of one scenario with several seeds: a row per seed, and means and spreads over them."""

import math
import statistics
from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Group
from rich.table import Table
from rich.text import Text

from luxloop.scenarios.report.cells import NONE, table_of, value_of
from luxloop.scenarios.report.html.reported_run import SUITE_METRICS
from luxloop.scenarios.report.text import COLORS
from luxloop.scenarios.result import Result


def seed_report(results: Sequence[Result], verdicts: Mapping[int, str]) -> Group:
    """Return the tables of runs that differ in their seeds.

    Parameters
    ----------
    results
        Runs that have a result.
    verdicts
        Verdict by seed, of all runs.
    """
    return Group(_each(results, verdicts), Text(), _spread(results), Text())


def summary(results: Sequence[Result]) -> dict[str, dict[str, Any]]:
    """Return mean, standard deviation and range over the seeds of each metric, for JSON; null without a value."""
    return {name: statistics_of(results, name) for name in (results[0].metrics if results else ())}


def statistics_of(results: Sequence[Result], name: str) -> dict[str, Any]:
    """Return mean, standard deviation and range of a metric over the seeds, its unit, and the seeds with a value."""
    found = [result.metrics[name].value for result in results]
    values = [value for value in found if value is not None]
    return {
        "mean": statistics.fmean(values) if values else None,
        "std": statistics.stdev(values) if len(values) > 1 else None,
        "min": min(values, default=None),
        "max": max(values, default=None),
        "unit": results[0].metrics[name].unit,
        "seeds": len(values),
    }


def _each(results: Sequence[Result], verdicts: Mapping[int, str]) -> Table:
    table = table_of("Each seed", "seed", *SUITE_METRICS.values())
    table.add_column("verdict", no_wrap=True)
    by_seed = {result.seed: result for result in results}
    for seed, verdict in verdicts.items():
        style = next((color for known, color in COLORS.items() if known == verdict), "red")
        values = [value_of(by_seed[seed].metrics[name]) if seed in by_seed else NONE for name in SUITE_METRICS]
        table.add_row(str(seed), *values, Text(verdict, style=style))
    return table


def _spread(results: Sequence[Result]) -> Table:
    """Return means and spreads of the main metrics and of those with expectations."""
    table = table_of("Over the seeds", "metric", "mean", "std", "least", "largest", "seeds")
    names = dict.fromkeys([*SUITE_METRICS, *(name for result in results for name in result.config["expect"])])
    for name in names if results else ():
        found = statistics_of(results, name)
        cells = [_number(found[part]) for part in ("mean", "std", "min", "max")]
        table.add_row(name, *cells, str(found["seeds"]))
    return table


def _number(value: float | None) -> str:
    return NONE if value is None or math.isnan(value) else f"{value:.3f}"
