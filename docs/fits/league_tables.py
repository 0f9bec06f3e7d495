"""Markdown tables of the comparison of the selection with its candidates."""

import math
from collections import Counter
from collections.abc import Iterable, Sequence

from fits.league import Standing

from luxloop.scenarios.statistics.intervals import FEWEST_CLUSTERS
from luxloop.tracker.records import METHODS

SHOWN = (*METHODS, "best", "oracle")


def table(standings: Iterable[Standing], *, by_scenario: bool) -> str:
    """Return a row per group: errors, and the difference from the best candidate with its interval."""
    first = ("scenario", "observations") if by_scenario else ("observations",)
    head = (*first, "n", "vehicles", *SHOWN, "best minus best candidate [95 %]", "")
    rows = [
        (*((one.scenario, one.group) if by_scenario else (one.group,)), one.n, one.vehicles, *cells(one))
        for one in standings
    ]
    return markdown(head, rows)


def cells(standing: Standing) -> tuple[str, ...]:
    """Return the errors, the least in bold, the difference and the verdict."""
    least = min(standing.means[method] for method in SHOWN if method != "oracle" and standing.means[method] >= 0.0)
    errors = [_error(standing.means[method], bold=standing.means[method] == least) for method in SHOWN]
    nearest = standing.losses[0] if standing.losses else standing.differences[0]
    interval = f" [{nearest.interval[0]:+.2f}, {nearest.interval[1]:+.2f}]" if nearest.interval else ""
    verdict = f"**loses** to {nearest.method}" if standing.losses else standing.verdict
    return (*errors, f"{nearest.mean:+.2f}{interval} ({nearest.method})", verdict)


def summary(standings: Sequence[Standing]) -> str:
    """Return the numbers of groups by verdict, in a sentence."""
    count = Counter(one.verdict for one in standings)
    parts = [f"{count[verdict]} {verdict}" for verdict in ("wins", "ties", "loses")]
    few = count["too few vehicles"]
    alone = f"; {few} have fewer than {FEWEST_CLUSTERS} vehicles and no interval" if few else ""
    return f"Of {len(standings)} groups, best: {', '.join(parts)}{alone}."


def markdown(head: Sequence[object], rows: Iterable[Sequence[object]]) -> str:
    """Return a Markdown table."""
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in (head, ["---"] * len(head), *rows))


def _error(value: float, *, bold: bool) -> str:
    shown = "n/a" if math.isnan(value) else f"{value:.2f}"
    return f"**{shown}**" if bold else shown
