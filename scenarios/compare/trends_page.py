"""Trends over baselines as one HTML page, and as a printed table."""

import shlex
from collections.abc import Sequence

import numpy as np
from markupsafe import Markup
from rich.table import Table
from rich.text import Text

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.compare.trend_figures import small_line, suite_figures
from luxloop.scenarios.compare.trend_values import KEY_METRICS, TITLES, Trends
from luxloop.scenarios.report.cells import NONE, table_of
from luxloop.scenarios.report.html.page_tables import page_table
from luxloop.scenarios.report.html.pages import render

HOTA = [metric.name for metric in KEY_METRICS].index("track.hota")
STYLES = {"worse": "red", "lost": "red", "better": "green", "unclear": "yellow"}


def trends_page(trends: Trends) -> str:
    """Return the page of trends over baselines."""
    return render(
        "trends.html.j2",
        trends=trends,
        figures=suite_figures(trends),
        suite=page_table(suite_table(trends)),
        metrics=[TITLES[metric.name] for metric in KEY_METRICS],
        scenarios=[(name, _lines(trends, name)) for name in _order(trends)],
        names={key: ", ".join(trends.labels[number] for number in found) for key, found in trends.changed.items()},
        command=shlex.join(["luxloop", "trends", *map(str, trends.paths)]),
    )


def suite_table(trends: Trends) -> Table:
    """Return a table of all common runs together: a row per baseline, with the verdicts against the one before."""
    table = table_of(f"All {len(trends.common)} common runs together", "baseline")
    for metric in KEY_METRICS:
        table.add_column(TITLES[metric.name], justify="right")
    for label, found, verdicts in zip(trends.labels, trends.suite, trends.verdicts, strict=True):
        cells = []
        for metric, value in zip(KEY_METRICS, found, strict=True):
            verdict = verdicts.get(metric.name, "")
            mark = f" {verdict}" if verdict in STYLES else ""
            cells.append(Text(_number(float(value), 4) + mark, style=STYLES.get(verdict, "")))
        table.add_row(label, *cells)
    return table


def _order(trends: Trends) -> list[str]:
    """Return the scenarios, those with the largest loss of HOTA from first to last first."""
    return sorted(trends.scenarios, key=lambda name: (_change(trends.scenarios[name][:, HOTA]), name))


def _change(values: Floats) -> float:
    """Return the last minus the first measured value; 0 without two."""
    seen = values[np.isfinite(values)]
    return float(seen[-1] - seen[0]) if len(seen) else 0.0


def _lines(trends: Trends, scenario: str) -> Sequence[tuple[Markup, str, str]]:
    """Return the small line of each metric, its last value, and its change from the first."""
    cells = []
    for metric, values in zip(KEY_METRICS, trends.scenarios[scenario].T, strict=True):
        seen = values[np.isfinite(values)]
        texts = [_number(float(value)) for value in values]
        name = f"{TITLES[metric.name]} of {scenario}: {', '.join(texts)}"
        line = small_line(values, trends.changed.get(scenario, []), metric, name)
        change = f"{_change(values):+.3f}" if len(seen) > 1 else ""
        cells.append((line, _number(float(seen[-1])) if len(seen) else NONE, change))
    return cells


def _number(value: float, digits: int = 3) -> str:
    return NONE if np.isnan(value) else f"{value:.{digits}f}"
