"""Comparison as a document, for the terminal, a page, Markdown, JSON and notebooks."""

import math
import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from luxloop.scenarios.compare.compared_metrics import COMPARED_METRICS, ComparedMetric
from luxloop.scenarios.compare.comparison import LEVEL, Comparison, ExpectationChange, MetricChange, ScenarioLoss
from luxloop.scenarios.compare.comparison_answer import answer, seeds_needed
from luxloop.scenarios.compare.digest import Expectation
from luxloop.scenarios.compare.run_pairs import Pair, listed
from luxloop.scenarios.document import html, markdown
from luxloop.scenarios.document.document import (
    Block,
    Bullets,
    Document,
    Facts,
    Paragraph,
    Preformatted,
    Section,
    Span,
    Style,
    Table,
    Words,
    code,
)
from luxloop.scenarios.document.figure import Figure
from luxloop.scenarios.document.palette import BAD, FAINT, GOOD, INK, LINE, PANEL, WARN
from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files import atomic_file
from luxloop.scenarios.metrics.main_figures import POOLED
from luxloop.scenarios.report.cells import NONE, table_of
from luxloop.scenarios.statistics.intervals import TOO_FEW

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas


SHOWN = 3.5
"""Largest change on the axis [stated losses]; arrows show that an interval continues."""
COLORS = {"worse": BAD, "lost": BAD, "better": GOOD, "unclear": WARN}


def change_figure(comparison: Comparison) -> Figure:
    """Draw the change of each metric, as a loss to the right and as a gain to the left."""
    shown = [change for change in comparison.changes if not math.isnan(change.numbers.difference)]

    def on(canvas: "Canvas") -> None:
        axes = canvas.subplots()
        axes.axvspan(1.0, SHOWN, color=PANEL, lw=0)
        axes.axvline(0.0, color=INK, lw=0.8)
        axes.axvline(1.0, color=FAINT, lw=0.8, ls=(0, (4, 3)))
        for row, change in enumerate(shown):
            _draw(axes, row, change, change.metric.relevance.stated_loss(change.numbers.base, comparison.loss))
        axes.set_yticks(range(len(shown)), [change.metric.name for change in shown], fontsize=7.0)
        axes.set(xlim=(-SHOWN, SHOWN), ylim=(len(shown) - 0.4, -0.6))
        axes.set_xlabel("better  ←  stated losses  →  worse")
        axes.grid(visible=False, axis="y")

    percent = f"{100.0 * comparison.loss:g} %"
    caption = (
        f"Dots are changes from BASE to HEAD, lines their 95 % intervals. An interval that reaches into the shaded "
        f"range contains the loss of {percent} that a comparison must exclude. Arrows continue beyond the axis."
    )
    return Figure("changes", "Change of each metric", caption, (5.4, 0.8 + 0.2 * max(len(shown), 3)), on)


def _draw(axes: "Axes", row: int, change: MetricChange, stated_loss: float) -> None:
    """Draw one metric in units of its stated loss, with the sign of a loss."""
    color = COLORS.get(change.verdict, FAINT)
    low, high = sorted(change.metric.loss(end) / stated_loss for end in change.numbers.interval)
    value = change.metric.loss(change.numbers.difference) / stated_loss
    axes.axhline(row, color=LINE, lw=0.4)
    if not math.isnan(low):
        axes.plot([max(low, -SHOWN), min(high, SHOWN)], [row, row], color=color, lw=2.0, solid_capstyle="butt")
        for end, marker in ((-SHOWN, "<"), (SHOWN, ">")):
            if low < end < high or (abs(end) < min(abs(low), abs(high)) and end * low > 0.0):
                axes.plot(end, row, marker, color=color, ms=6, clip_on=False)
    beyond = abs(value) > SHOWN
    marker = (">" if value > 0.0 else "<") if beyond else "o"
    axes.plot(min(max(value, -SHOWN), SHOWN), row, marker, color=color, ms=6 if beyond else 5, clip_on=False)


INTERVALS = (
    "The 95 % interval of a change follows from its spread as each vehicle is left out in turn: an interval that "
    "contains 0 is no evidence of a change."
)
"""Explanation of the intervals."""
STYLES: dict[str, Style] = {
    "worse": "bad", "lost": "bad", "newly failed": "bad", "unclear": "warn", "now known to fail": "warn",
    "better": "good", "mended": "good",
}  # fmt: skip
"""Colour of the verdict on a metric, and of the fate of an expectation."""


def comparison_document(comparison: Comparison, base: str, head: str) -> Document:
    """Return a comparison as a document; `base` and `head` are the names of the two sides."""
    pairs = comparison.pairs.compared
    facts = Facts(
        {
            "BASE": code(base),
            "HEAD": code(head),
            "pairs of runs": str(len(pairs)),
            "of these differ": str(sum(not pair.same for pair in pairs)),
        }
    )
    command = shlex.join(["luxloop", "compare", base, head, "--loss", f"{100.0 * comparison.loss:g}"])
    sections = [
        Section("summary", "What changed", list(_statements(comparison))),
        Section("metrics", "Metrics", list(_metrics(comparison))),
        Section("scenarios", "Losses in single scenarios", [_scenarios(comparison.scenario_losses)]),
        Section("expectations", "Expectations that fail on a side", [_expectations(comparison)]),
        Section("runs", "Runs", [Bullets(compared_runs(comparison))]),
        Section("pairs", "Each pair of runs", [run_table(pairs)], page_only=True),
        Section("again", "Reproduce", [Preformatted(command)], page_only=True),
    ]
    said = answer(comparison)
    return Document(
        title="Comparison of two versions",
        answer=said,
        lead=[change_figure(comparison), facts],
        sections=sections,
        data={"base": base, "head": head, **_data(comparison)},
        name=f"{said.verdict}: {base} and {head}",
    )


def _statements(comparison: Comparison) -> Iterator[Bullets]:
    """Yield the changes below headings, the losses first."""
    early = [(code(str(key)), f": {comparison.pairs.incomparable[key]}") for key in comparison.pairs.newly_incomplete]
    alone = [_alone(loss) for loss in comparison.scenario_losses]
    groups: dict[str, list[Words]] = {
        "Newly incomplete": [*early],
        "Newly failed": _of_fate(comparison, "newly failed"),
        "Worse": [*_of_verdict(comparison, "lost"), *_of_verdict(comparison, "worse"), *alone],
        "Now known to fail": _of_fate(comparison, "now known to fail"),
        "Cannot tell": _of_verdict(comparison, "unclear"),
        "Better": [*_of_verdict(comparison, "better"), *_of_fate(comparison, "mended")],
    }
    for heading, found in groups.items():
        if found:
            yield Bullets(found, heading)


def _of_verdict(comparison: Comparison, verdict: str) -> list[Words]:
    return [_changed(change) for change in comparison.changes if change.verdict == verdict]


def _of_fate(comparison: Comparison, fate: str) -> list[Words]:
    return [_fate(change) for change in comparison.expectation_changes if change.fate == fate]


def _changed(change: MetricChange) -> Words:
    numbers, unit = change.numbers, "" if change.metric.unit == "1" else f" {change.metric.unit}"
    text = f"{number(numbers.base)} to {number(numbers.head)}{unit}"
    if change.verdict != "lost":
        text += f" ({number(numbers.difference, sign='+')}; 95 %: {interval(change)})"
    return code(change.metric.name), f": {text}" + (f"; most in {listed(change.where)}" if change.where else "")


def _alone(loss: ScenarioLoss) -> Words:
    text = f"{number(loss.base)} to {number(loss.head)}, {loss.units} vehicles, p = {loss.p:.2g}"
    return code(loss.scenario), f": alone: {loss.metric.name} {text}"


def _fate(change: ExpectationChange) -> Words:
    values = f"{expected_value(change.base)} to {expected_value(change.head)}"
    return code(str(change.key)), f": {change.name} {change.head.limit}: {values}"


def _metrics(comparison: Comparison) -> Iterator[Block]:
    """Yield a table with a row per metric; changed ones are followed by the runs with the largest contributions."""
    table = table_of("Metrics", "metric", "BASE", "HEAD", "change", "95 % interval")
    table.add_column("unit")
    table.add_column("verdict", no_wrap=True)
    for change in comparison.changes:
        if change.verdict == "not measured":
            continue
        numbers, unit = change.numbers, "" if change.metric.unit == "1" else change.metric.unit
        values = (number(numbers.base), number(numbers.head), number(numbers.difference, "+"), interval(change))
        table.add_row(code(change.metric.name), *values, unit, Span(change.verdict, STYLES.get(change.verdict, "")))
        for key, moved in change.where.items():
            table.add_row(f"  {key}", "", "", number(moved, "+"), style="dim")
    yield table
    absent = [change.metric.name for change in comparison.changes if change.verdict == "not measured"]
    yield Paragraph(f"{INTERVALS} {false_positives(comparison)}.", "dim")
    if absent:
        yield Paragraph(f"No observations: {', '.join(absent)}.", "dim")


def _scenarios(losses: Sequence[ScenarioLoss]) -> Table:
    """Return a table with the clearest loss of each scenario that has one."""
    table = table_of("Losses in single scenarios", "scenario", "metric", "BASE", "HEAD", "vehicles", "p")
    for loss in losses:
        values = (number(loss.base), number(loss.head), str(loss.units), f"{loss.p:.2g}")
        table.add_row(code(loss.scenario), code(loss.metric.name), *values)
    return table


def _expectations(comparison: Comparison) -> Table:
    """Return a table of the expectations that fail on at least one side."""
    table = table_of("Expectations", "run", "limit", "BASE", "HEAD")
    table.add_column("", no_wrap=True)
    for change in comparison.expectation_changes:
        values = (expected_value(change.base), expected_value(change.head))
        fate = Span(change.fate, STYLES.get(change.fate, ""))
        table.add_row(code(str(change.key)), code(f"{change.name} {change.head.limit}"), *values, fate)
    return table


def compared_runs(comparison: Comparison) -> list[str]:
    """Return the numbers of compared runs, the runs left out with the reason, and notes."""
    pairs = comparison.pairs
    identical = sum(pair.identical for pair in pairs.compared)
    same = sum(pair.same for pair in pairs.compared if not pair.identical)
    lines = [f"{len(pairs.compared)} pairs of runs compared, {identical} of them identical (same trace hash)"]
    lines += [f"{same} more are equal within the tolerances, as runs on different CPUs are"] if same else []
    if comparison.measured < len(pairs.compared):
        lines.append(f"The metrics are those of the {comparison.measured} pairs that differ")
    lines += [f"Not compared: {key}: {why}" for key, why in pairs.incomparable.items()]
    lines += [f"Only in BASE: {listed(pairs.only_base)}"] if pairs.only_base else []
    lines += [f"Only in HEAD: {listed(pairs.only_head)}"] if pairs.only_head else []
    return [*lines, *pairs.notes]


def run_table(pairs: Sequence[Pair]) -> Table:
    """Return BASE's and HEAD's key metrics of each pair of runs, those with the largest loss of HOTA first."""
    shown = POOLED.keys() - {"track.idf1"}  # its column would not fit on a page of 1280 pixels
    metrics = [metric for metric in COMPARED_METRICS if metric.name in shown]
    table = Table("BASE to HEAD")
    table.add_column("run")
    table.add_column("tracks")
    for name in ("vehicles", *(POOLED[metric.name] for metric in metrics)):
        table.add_column(name, justify="right")
    rows = sorted(((_loss(pair, metrics[0]), pair) for pair in pairs), key=lambda row: -row[0])
    for _, pair in rows:
        state = (
            "identical" if pair.identical else "same" if pair.same else "differ" if pair.same_truth else "other traffic"
        )
        vehicles = str(len(pair.base.vehicles.vehicle) - 1)
        table.add_row(str(pair.key), state, vehicles, *_pooled(pair, metrics), style="dim" if pair.same else "")
    return table


def _loss(pair: Pair, metric: ComparedMetric) -> float:
    base, head = (float(metric.value(sums.sum(axis=0, keepdims=True))[0]) for sums in pair.units())
    loss = metric.loss(head - base)
    return 0.0 if math.isnan(loss) else loss


def _pooled(pair: Pair, metrics: Sequence[ComparedMetric]) -> list[str]:
    base, head = (sums.sum(axis=0, keepdims=True) for sums in pair.units())
    values = [(float(metric.value(base)[0]), float(metric.value(head)[0])) for metric in metrics]
    return [_short(b) if pair.same else f"{_short(b)} to {_short(h)}" for b, h in values]


def false_positives(comparison: Comparison) -> str:
    """Return the sentence on the probability of a wrong verdict."""
    single = f", and {LEVEL:.0%} of a loss in a single scenario" if comparison.scenarios_tested else ""
    return f"Without any change, the probability of a better or worse is {LEVEL:.0%}{single}"


def number(value: float, sign: str = "") -> str:
    """Format a metric with four decimals."""
    return NONE if math.isnan(value) else f"{value:{sign}.4f}"


def interval(change: MetricChange) -> str:
    """Format the interval of a change, or say that it has none."""
    ends = change.numbers.interval
    return TOO_FEW if math.isnan(ends[0]) else " to ".join(number(end, sign="+") for end in ends)


def expected_value(expectation: Expectation) -> str:
    """Format the value of an expectation."""
    return NONE if expectation.value is None else f"{expectation.value:.4g}"


def _short(value: float) -> str:
    """Format a metric with three decimals, so that the table fits the page."""
    return NONE if math.isnan(value) else f"{value:.3f}"


def _data(comparison: Comparison) -> dict[str, Any]:
    """Return the figures for programs."""
    pairs, seeds = comparison.pairs, seeds_needed(comparison)
    return {
        "failed": comparison.failed,
        "level": LEVEL,
        "stated_loss": comparison.loss,
        "pairs_measured": comparison.measured,
        "seeds": seeds.now,
        "seeds_needed": seeds.needed if comparison.verdict == "cannot tell" else None,
        "metrics": {change.metric.name: _metric_data(change) for change in comparison.changes},
        "scenario_losses": [
            {"scenario": one.scenario, "metric": one.metric.name, "base": one.base, "head": one.head, "p": one.p,
             "units": one.units}
            for one in comparison.scenario_losses
        ],
        "expectations": [
            {**one.key._asdict(), "metric": one.name, "limit": one.head.limit,
             "base": one.base.value, "head": one.head.value, "fate": one.fate}
            for one in comparison.expectation_changes
        ],
        "pairs": [_pair_data(pair) for pair in pairs.compared],
        "not_compared": [{**key._asdict(), "reason": why} for key, why in pairs.incomparable.items()],
        "newly_incomplete": [key._asdict() for key in pairs.newly_incomplete],
        "only_in_base": [key._asdict() for key in pairs.only_base],
        "only_in_head": [key._asdict() for key in pairs.only_head],
        "notes": pairs.notes,
    }  # fmt: skip


def _metric_data(change: MetricChange) -> dict[str, Any]:
    numbers = change.numbers
    return {
        "unit": change.metric.unit,
        "better": change.metric.better,
        "base": numbers.base,
        "head": numbers.head,
        "difference": numbers.difference,
        "interval": numbers.interval,
        "p": numbers.p,
        "margin": change.margin,
        "verdict": change.verdict,
        "where": [{**key._asdict(), "difference": moved} for key, moved in change.where.items()],
    }


def _pair_data(pair: Pair) -> dict[str, Any]:
    """Return the metrics of a single pair, for information; the verdict is based on the pooled runs."""
    base, head = (sums.sum(axis=0, keepdims=True) for sums in pair.units())
    return {
        **pair.key._asdict(),
        "identical": pair.identical,
        "same": pair.same,
        "same_truth": pair.same_truth,
        "metrics": {m.name: [m.value(base)[0], m.value(head)[0]] for m in COMPARED_METRICS},
    }


RENDERERS = {".html": html.page, ".md": markdown.markdown}
STEM = "comparison"
"""Name of the files in a folder."""


def files_of(report: Path) -> list[Path]:
    """Return the files to write.

    Raises
    ------
    OutputError
        The name ends neither like a page, nor like Markdown, nor like a folder.
    """
    if report.is_dir() or not report.suffix:
        return [report / f"{STEM}{suffix}" for suffix in RENDERERS]
    if report.suffix not in RENDERERS:
        raise OutputError(f"--report {report}: give a name that ends in .html or .md, or a folder for both")
    return [report]


def write(files: list[Path], document: Document) -> None:
    """Write the files, each in the format of its name.

    Raises
    ------
    OutputError
        A file cannot be written.
    """
    for file in files:
        atomic_file.save_text(file, RENDERERS[file.suffix](document), "--report")
