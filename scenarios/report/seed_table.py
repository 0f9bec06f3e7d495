"""Runs of one scenario with several seeds: a row per seed, and means and spreads over them."""

import math
import statistics
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from luxloop.scenarios.document.document import Answer, Document, Section
from luxloop.scenarios.document.table import Table
from luxloop.scenarios.document.words import Span, Style
from luxloop.scenarios.report.cells import NONE, table_of, value_of
from luxloop.scenarios.report.html.reported_run import SUITE_METRICS
from luxloop.scenarios.report.run_answer import STYLES
from luxloop.scenarios.result import Result

WORST_FIRST = ("broken tracker", "failed", "incomplete", "no limits", "passed")
"""Verdicts of runs; that of all runs is the first of theirs."""
STYLE_OF: Mapping[str, Style] = {"broken tracker": "bad", **{str(one): style for one, style in STYLES.items()}}


def seeds_document(done: Mapping[int, Result], verdicts: Mapping[int, str]) -> Document:
    """Return runs that differ in their seeds.

    Parameters
    ----------
    done
        Runs that have a result, by seed.
    verdicts
        Verdict by seed, of all runs.
    """
    results = list(done.values())
    sections = [
        Section("each", "Each seed", [_each(results, verdicts)]),
        Section("spread", "Over the seeds", [_spread(results)]),
    ]
    return Document(seeds_name(done, verdicts), seeds_answer(verdicts), [], sections)


def seeds_name(done: Mapping[int, Result], verdicts: Mapping[int, str]) -> str:
    """Return the scenario and its seeds."""
    scenario = next((result.scenario for result in done.values()), "no run")
    return f"{scenario}, seeds {min(verdicts)}-{max(verdicts)}"


def seeds_answer(verdicts: Mapping[int, str]) -> Answer:
    """Return the worst verdict, and the number of seeds with each."""
    count = Counter(verdicts.values())
    present = [verdict for verdict in WORST_FIRST if count[verdict]]
    said = ", ".join(f"{count[verdict]} {verdict}" for verdict in present)
    return Answer(said, present[0], STYLE_OF[present[0]])


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
        values = [value_of(by_seed[seed].metrics[name]) if seed in by_seed else NONE for name in SUITE_METRICS]
        table.add_row(str(seed), *values, Span(verdict, STYLE_OF[verdict]))
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
