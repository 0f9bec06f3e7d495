"""Trends over baselines as a document."""

import shlex

import numpy as np

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.compare.comparison_document import STYLES
from luxloop.scenarios.compare.trend_figures import small_line, suite_figures
from luxloop.scenarios.compare.trend_values import KEY_METRICS, TITLES, Trends
from luxloop.scenarios.document.document import Answer, Bullets, Document, Facts, Paragraph, Preformatted, Section
from luxloop.scenarios.document.table import Table
from luxloop.scenarios.document.words import Span, Words, code
from luxloop.scenarios.report.cells import NONE, counted

HOTA = [metric.name for metric in KEY_METRICS].index("track.hota")
DOTS = (
    "Large dots mark a verdict of luxloop compare against the baseline before: green better, orange-red worse, ochre "
    "unclear. Every axis spans at least ten times the smallest relevant difference."
)
LINES = (
    "A small line per metric, with the last value and its change from the first; the largest loss of HOTA comes first. "
    "Each line has its own axis. A hollow dot is a baseline with a changed scenario, whose values are not comparable "
    "with those before."
)


def trends_document(trends: Trends) -> Document:
    """Return the trends over baselines as a document."""
    first, *others = sorted(suite_figures(trends), key=lambda figure: figure.name != f"suite-{HOTA}")
    names = {key: ", ".join(trends.labels[number] for number in found) for key, found in trends.changed.items()}
    changed: list[Words] = [(code(name), f" in {where}") for name, where in names.items()]
    sections = [
        Section("suite", "All common runs together", [*others, suite_table(trends), Paragraph(DOTS, "dim")]),
        Section("scenarios", "Each scenario", [_scenarios(trends), Paragraph(LINES, "dim")], page_only=True),
        Section("changed", "Changed scenarios", [Bullets(changed)] if changed else [], page_only=True),
        Section(
            "again",
            "Reproduce",
            [Preformatted(shlex.join(["luxloop", "trends", *map(str, trends.paths)]))],
            page_only=True,
        ),
    ]
    facts = {
        "common runs": str(len(trends.common)),
        "scenarios": str(len(trends.scenarios)),
        "scenarios changed on the way": str(len(trends.changed)),
    }
    return Document(
        title=f"Trends over {len(trends.labels)} baselines",
        answer=Answer(_sentence(trends)),
        lead=[first, Facts(facts, large=True)],
        sections=sections,
    )


def _sentence(trends: Trends) -> str:
    """Return the change of HOTA from first to last, and the verdicts on the last step."""
    hota = trends.suite[:, HOTA]
    ends = f"from {hota[0]:.3f} in {trends.labels[0]} to {hota[-1]:.3f} in {trends.labels[-1]}"
    moved = "is unchanged" if abs(hota[-1] - hota[0]) < 5e-4 else "rose" if hota[-1] > hota[0] else "fell"
    last = trends.verdicts[-1].values()
    worse, better = sum(one in ("worse", "lost") for one in last), sum(one == "better" for one in last)
    step = f"in the last step {counted(worse, 'metric')} became worse and {better} better"
    return f"HOTA {moved}, {ends}; {step}"


def suite_table(trends: Trends) -> Table:
    """Return a table of all common runs together: a row per baseline, with the verdicts against the one before."""
    table = Table(f"All {len(trends.common)} common runs together")
    table.add_column("baseline")
    for metric in KEY_METRICS:
        table.add_column(TITLES[metric.name], justify="right")
    for label, found, verdicts in zip(trends.labels, trends.suite, trends.verdicts, strict=True):
        cells = []
        for metric, value in zip(KEY_METRICS, found, strict=True):
            verdict = verdicts.get(metric.name, "")
            mark = f" {verdict}" if verdict in STYLES else ""
            cells.append(Span(_number(float(value), 4) + mark, STYLES.get(verdict, "")))
        table.add_row(label, *cells)
    return table


def _scenarios(trends: Trends) -> Table:
    """Return a row per scenario, with a small line for each metric."""
    table = Table("")
    for name in ("scenario", *(TITLES[metric.name] for metric in KEY_METRICS)):
        table.add_column(name)
    for scenario in _order(trends):
        table.add_row(scenario, *_lines(trends, scenario))
    return table


def _order(trends: Trends) -> list[str]:
    """Return the scenarios, those with the largest loss of HOTA from first to last first."""
    return sorted(trends.scenarios, key=lambda name: (_change(trends.scenarios[name][:, HOTA]), name))


def _change(values: Floats) -> float:
    """Return the last minus the first measured value; 0 without two."""
    seen = values[np.isfinite(values)]
    return float(seen[-1] - seen[0]) if len(seen) else 0.0


def _lines(trends: Trends, scenario: str) -> list[Words]:
    """Return the small line of each metric, its last value, and its change from the first."""
    cells: list[Words] = []
    for metric, values in zip(KEY_METRICS, trends.scenarios[scenario].T, strict=True):
        seen = values[np.isfinite(values)]
        texts = [_number(float(value)) for value in values]
        name = f"{TITLES[metric.name]} of {scenario}: {', '.join(texts)}"
        line = small_line(values, trends.changed.get(scenario, []), metric, name)
        change = f" {_change(values):+.3f}" if len(seen) > 1 else ""
        cells.append((Span(_number(float(seen[-1])) if len(seen) else NONE, drawing=line), Span(change, "dim")))
    return cells


def _number(value: float, digits: int = 3) -> str:
    return NONE if np.isnan(value) else f"{value:.{digits}f}"
