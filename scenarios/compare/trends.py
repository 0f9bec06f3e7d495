"""Key metrics over many baselines, of all runs together and of each scenario: values, figures and their document."""

import shlex
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup, escape

from luxloop.arrays import Floats
from luxloop.scenarios.compare import run_pairs
from luxloop.scenarios.compare.compared_metrics import COMPARED_METRICS, ComparedMetric, values
from luxloop.scenarios.compare.comparison import MetricVerdict, compare
from luxloop.scenarios.compare.comparison_document import STYLES
from luxloop.scenarios.compare.digest import Key, RunDigest, differing
from luxloop.scenarios.compare.run_pairs import Side
from luxloop.scenarios.document.document import (
    Answer,
    Bullets,
    Document,
    Facts,
    Paragraph,
    Preformatted,
    Section,
    Span,
    Table,
    Words,
    code,
)
from luxloop.scenarios.document.figure import Figure
from luxloop.scenarios.document.palette import BAD, BLUE, GOOD, WARN
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.metrics.main_figures import POOLED
from luxloop.scenarios.report.cells import NONE, counted

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas


KEY_METRICS = tuple(metric for metric in COMPARED_METRICS if metric.name in POOLED)


@dataclass(frozen=True, slots=True, eq=False)
class Trends:
    """M key metrics over B baselines, in the order of the command line."""

    labels: list[str]
    """(B,) short names of the baselines."""
    paths: list[Path]
    common: list[Key]
    """Complete runs of all baselines, which the suite's values are pooled over."""
    suite: Floats
    """(B, M) metrics of all common runs together."""
    scenarios: dict[str, Floats]
    """(B, M) metrics of the runs of each scenario; NaN where a baseline has none."""
    changed: dict[str, list[int]]
    """Numbers of the baselines whose scenario differs from that of the baseline before, by scenario."""
    verdicts: list[dict[str, MetricVerdict]]
    """(B,) verdict of each metric against the baseline before; empty where no pair can be compared."""


def trends(sides: Sequence[Side]) -> Trends:
    """Return the trends over baselines.

    Raises
    ------
    InputError
        There are fewer than two baselines, or no complete run is in all of them.
    """
    if len(sides) < 2:
        raise InputError(f"{sides[0].path}: the only baseline; give at least two, the earliest first")
    complete = [{key: run for key, run in side.runs.items() if not run.ended_early} for side in sides]
    common = sorted(set.intersection(*(set(runs) for runs in complete)))
    if not common:
        raise InputError("no complete run is in all baselines; give baselines with the same scenarios and seeds")
    names = sorted({key.scenario for runs in complete for key in runs})
    return Trends(
        labels=labels([side.path for side in sides]),
        paths=[side.path for side in sides],
        common=common,
        suite=np.vstack([_values([runs[key] for key in common]) for runs in complete]),
        scenarios={name: np.vstack([_values(_of(name, runs.values())) for runs in complete]) for name in names},
        changed={name: found for name in names if (found := _changed([_of(name, runs.values()) for runs in complete]))},
        verdicts=[{}, *(_verdicts(before, after) for before, after in pairwise(sides))],
    )


def labels(paths: Sequence[Path]) -> list[str]:
    """Return the names of files without their endings, or the shortest ends of the paths that are all different."""
    parts = [(*path.parts[:-1], path.stem if path.suffix == ".jsonl" else path.name) for path in paths]
    for length in range(1, max(map(len, parts)) + 1):
        names = ["/".join(part[-length:]) for part in parts]
        if len(set(names)) == len(names):
            return names
    return [f"{number}: {'/'.join(part)}" for number, part in enumerate(parts, start=1)]


def _of(scenario: str, runs: Iterable[RunDigest]) -> list[RunDigest]:
    return [run for run in runs if run.key.scenario == scenario]


def _values(runs: list[RunDigest]) -> Floats:
    """(M,) key metrics of several runs together; NaN without a run."""
    if not runs:
        return np.full(len(KEY_METRICS), np.nan)
    sums = np.vstack([run.vehicles.columns() for run in runs]).sum(axis=0, keepdims=True)
    found: Floats = values(sums, KEY_METRICS)[0]
    return found


def _changed(runs: list[list[RunDigest]]) -> list[int]:
    """Return the numbers of the baselines in which the scenario differs from the one before."""
    found = []
    for number, (before, after) in enumerate(pairwise(runs), start=1):
        if before and after and set(differing(before[0].sections, after[0].sections)) - set(run_pairs.MAY_DIFFER):
            found.append(number)
    return found


def _verdicts(before: Side, after: Side) -> dict[str, MetricVerdict]:
    try:
        comparison = compare(run_pairs.pair(before, after))
    except InputError:  # no pair can be compared
        return {}
    return {change.metric.name: change.verdict for change in comparison.changes if change.metric.name in POOLED}


COLORS: dict[MetricVerdict, str] = {"worse": BAD, "lost": BAD, "better": GOOD, "unclear": WARN}
LONGEST_LABEL = 14
"""Characters of a name under an axis; the table beside the figures has the whole names."""
SPAN = 10.0
"""Smallest height of a small line [smallest relevant differences], so that noise looks flat."""
WIDTH, HEIGHT, EDGE = 96.0, 24.0, 4.0
"""Size of a small line and its margin [px]."""


def suite_figures(trends: Trends) -> list[Figure]:
    """Draw each key metric over the baselines, with the verdict against the baseline before as colour."""
    return [_suite_figure(trends, number, metric) for number, metric in enumerate(KEY_METRICS)]


def _suite_figure(trends: Trends, number: int, metric: ComparedMetric) -> Figure:
    shown = trends.suite[:, number]

    def on(canvas: "Canvas") -> None:
        axes = canvas.subplots()
        at = np.arange(len(shown))
        axes.plot(at, shown, color=BLUE, lw=1.6)
        for place, (value, verdicts) in enumerate(zip(shown, trends.verdicts, strict=True)):
            color = COLORS.get(verdicts.get(metric.name, "same"), BLUE)
            axes.plot(place, value, "o", color=color, ms=7 if color != BLUE else 4)
        low, high = _range(shown, metric)
        axes.set(xlim=(-0.3, len(shown) - 0.7), ylim=(low, high))
        axes.set_xticks(at, [_axis_label(label) for label in trends.labels], rotation=30, ha="right", fontsize=7.5)

    title = f"{POOLED[metric.name]}: {metric.better} is better"
    return Figure(f"suite-{number}", title, f"{metric.name} of all common runs together.", (5.0, 2.9), on)


def _axis_label(label: str) -> str:
    return label if len(label) <= LONGEST_LABEL else f"..{label[-LONGEST_LABEL + 2 :]}"


def small_line(values: Floats, changed: list[int], metric: ComparedMetric, name: str) -> Markup:
    """Draw one metric of one scenario over the baselines; hollow dots: the scenario itself was changed there."""
    low, high = _range(values, metric)
    x = np.linspace(EDGE, WIDTH - EDGE, len(values))
    y = EDGE + (HEIGHT - 2 * EDGE) * (high - values) / (high - low)
    parts = [
        f'<polyline points="{" ".join(f"{x[k]:.1f},{y[k]:.1f}" for k in run)}"/>'
        for run in _unbroken(np.isfinite(values), changed)
        if len(run) > 1
    ]
    parts += [f'<circle class="new" cx="{x[k]:.1f}" cy="{y[k]:.1f}" r="2"/>' for k in changed if np.isfinite(y[k])]
    seen = np.flatnonzero(np.isfinite(values))
    parts += [f'<circle cx="{x[k]:.1f}" cy="{y[k]:.1f}" r="2"/>' for k in seen[-1:]]
    opening = f'<svg class="small" viewBox="0 0 {WIDTH:g} {HEIGHT:g}" role="img" aria-label="{escape(name)}">'
    return Markup(opening + "".join(parts) + "</svg>")


def _unbroken(measured: "np.ndarray[tuple[int], np.dtype[np.bool_]]", changed: list[int]) -> list[list[int]]:
    """Split the measured baselines at gaps and where the scenario was changed."""
    runs: list[list[int]] = [[]]
    for place in range(len(measured)):
        if not measured[place] or place in changed:
            runs.append([])
        if measured[place]:
            runs[-1].append(place)
    return runs


def _range(values: Floats, metric: ComparedMetric) -> tuple[float, float]:
    """Return the limits of an axis, at least `SPAN` of the smallest relevant differences apart."""
    seen = values[np.isfinite(values)]
    low, high = (float(seen.min()), float(seen.max())) if len(seen) else (0.0, 1.0)
    missing = SPAN * metric.relevance.margin(high) - (high - low)
    half = max(missing, 0.1 * (high - low)) / 2.0
    bottom = max(low - half, 0.0) if low >= 0.0 else low - half
    return bottom, bottom + (high - low) + 2.0 * half


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
        table.add_column(POOLED[metric.name], justify="right")
    for label, found, verdicts in zip(trends.labels, trends.suite, trends.verdicts, strict=True):
        cells = []
        for metric, value in zip(KEY_METRICS, found, strict=True):
            verdict = verdicts.get(metric.name, "")
            mark = f" {verdict}" if verdict in STYLES else ""
            cells.append(Span(_shown(float(value), 4) + mark, STYLES.get(verdict, "")))
        table.add_row(label, *cells)
    return table


def _scenarios(trends: Trends) -> Table:
    """Return a row per scenario, with a small line for each metric."""
    table = Table("")
    for name in ("scenario", *(POOLED[metric.name] for metric in KEY_METRICS)):
        table.add_column(name)
    for scenario in sorted(trends.scenarios, key=lambda name: (_change(trends.scenarios[name][:, HOTA]), name)):
        table.add_row(scenario, *_lines(trends, scenario))
    return table


def _change(values: Floats) -> float:
    """Return the last minus the first measured value; 0 without two."""
    seen = values[np.isfinite(values)]
    return float(seen[-1] - seen[0]) if len(seen) else 0.0


def _lines(trends: Trends, scenario: str) -> list[Words]:
    """Return the small line of each metric, its last value, and its change from the first."""
    cells: list[Words] = []
    for metric, found in zip(KEY_METRICS, trends.scenarios[scenario].T, strict=True):
        seen = found[np.isfinite(found)]
        texts = [_shown(float(value)) for value in found]
        name = f"{POOLED[metric.name]} of {scenario}: {', '.join(texts)}"
        line = small_line(found, trends.changed.get(scenario, []), metric, name)
        change = f" {_change(found):+.3f}" if len(seen) > 1 else ""
        cells.append((Span(_shown(float(seen[-1])) if len(seen) else NONE, drawing=line), Span(change, "dim")))
    return cells


def _shown(value: float, digits: int = 3) -> str:
    return NONE if np.isnan(value) else f"{value:.{digits}f}"
