"""Answer of a comparison: the one verdict and sentence of its terminal, page, Markdown, JSON and exit code."""

import math
from collections import Counter
from dataclasses import dataclass

from luxloop.scenarios.compare.comparison import LEVEL, Comparison, MetricChange, Verdict
from luxloop.scenarios.document.document import Answer, Style
from luxloop.scenarios.report.cells import NONE, counted


@dataclass(frozen=True, slots=True)
class SeedsNeeded:
    """Seeds of each scenario."""

    now: int
    """Most seeds of a scenario whose runs differ."""
    needed: int | None
    """None if no number can be named."""
    unbounded: str = ""
    """A metric whose measured loss is the stated one or larger: more seeds would confirm it."""
    without_interval: str = ""
    """A metric with too few vehicles for an interval."""


def seeds_needed(comparison: Comparison) -> SeedsNeeded:
    """Return how many seeds would exclude the stated loss in every unclear metric, if the measured change is true.

    The half-width of an interval falls with the root of the number n of seeds. It must become the distance of the
    change from the limit: n_needed = n * (half-width / distance)^2. Student's quantile falls with n, too, which is
    left out, so that the number is rather too large for few vehicles.
    """
    pairs = [pair for pair in comparison.pairs.compared if not pair.same] or comparison.pairs.compared
    now = max(Counter(pair.key.scenario for pair in pairs).values())
    unclear = [change for change in comparison.changes if change.verdict == "unclear"]
    factors = {change.metric.name: _factor(change, comparison.loss) for change in unclear}
    for name, factor in factors.items():
        if math.isnan(factor):
            return SeedsNeeded(now, None, without_interval=name)
    for name, factor in factors.items():
        if math.isinf(factor):
            return SeedsNeeded(now, None, unbounded=name)
    return SeedsNeeded(now, max((math.ceil(now * factor) for factor in factors.values()), default=now))


def _factor(change: MetricChange, share: float) -> float:
    """Return n_needed / n; infinite if the change is at the limit or beyond, NaN without an interval."""
    numbers, metric = change.numbers, change.metric
    half = 0.5 * (numbers.interval[1] - numbers.interval[0])
    distance = metric.relevance.stated_loss(numbers.base, share) - metric.loss(numbers.difference)
    if math.isnan(half):
        return math.nan
    return (half / distance) ** 2 if distance > 0.0 else math.inf


STYLES: dict[Verdict, Style] = {"worse": "bad", "cannot tell": "warn", "better": "good", "same": "good"}
SAID = {
    "track.missed_share": ("misses more vehicles", "misses fewer vehicles"),
    "track.false_share": ("reports more false tracks", "reports fewer false tracks"),
    "track.hota": ("tracks worse as a whole (HOTA)", "tracks better as a whole (HOTA)"),
    "track.id_switch_rate": ("switches ids more often", "switches ids less often"),
    "track.occlusion_survival": ("loses more vehicles in occlusions", "loses fewer vehicles in occlusions"),
    "fit.heading_abs_mean_deg": ("fits headings worse", "fits headings better"),
    "fit.position_abs_mean_m": ("fits positions worse", "fits positions better"),
}
"""A worse and a better value in words, the most important metric first."""
PERCENT = ("track.missed_share", "track.false_share", "track.occlusion_survival")
"""Metrics that are shown in percent."""


def answer(comparison: Comparison) -> Answer:
    """Return the verdict of a comparison with its sentence."""
    verdict = comparison.verdict
    say = {"worse": _worse, "cannot tell": _cannot_tell, "better": _better, "same": _same}[verdict]
    return Answer(say(comparison), verdict, STYLES[verdict])


def _worse(comparison: Comparison) -> str:
    losses = [change for change in comparison.changes if change.verdict in ("worse", "lost")]
    alone, early = comparison.scenario_losses, comparison.pairs.newly_incomplete
    failed = sum(change.fate == "newly failed" for change in comparison.expectation_changes)
    parts = {
        f"{len(losses)} of {len(comparison.changes)} metrics": len(losses),
        f"{len(alone)} of {counted(len(comparison.scenarios), 'scenario')}": len(alone),
    }
    found = [what for what, count in parts.items() if count]
    is_are = "is" if len(losses) + len(alone) == 1 else "are"
    said = [f"{' and '.join(found)} {is_are} worse"] if found else []
    said += [f"{counted(failed, 'expectation')} newly fail{'s' if failed == 1 else ''}"] if failed else []
    said += [f"{counted(len(early), 'run')} newly end{'s' if len(early) == 1 else ''} early"] if early else []
    chance = f"; the chance of a false alarm is {100.0 * LEVEL:g} %" if found else ""
    first = f"HEAD {_headline(losses, 0)}; " if losses else "HEAD is worse than BASE: "
    return f"{first}{', '.join(said)}{chance}"


def _better(comparison: Comparison) -> str:
    gains = [change for change in comparison.changes if change.verdict == "better"]
    return f"HEAD {_headline(gains, 1)}; {_excluded(comparison)}"


def _same(comparison: Comparison) -> str:
    return f"HEAD is as good as BASE; {_excluded(comparison)}"


def _excluded(comparison: Comparison) -> str:
    return f"no metric is worse, and a loss of {percent(comparison)} is excluded, to 95 % for each metric"


def _cannot_tell(comparison: Comparison) -> str:
    unclear = [change.metric.name for change in comparison.changes if change.verdict == "unclear"]
    if not unclear:
        return "The runs cannot tell whether HEAD is worse: no metric has a value"
    which = unclear[0] if len(unclear) == 1 else f"{len(unclear)} of {len(comparison.changes)} metrics"
    lost = f"a loss of {percent(comparison)} is not excluded for {which}"
    return f"The runs cannot tell whether HEAD is worse: {lost}; {needed_text(seeds_needed(comparison))}"


def needed_text(found: SeedsNeeded) -> str:
    """Return how many seeds would be needed, or why no number can be named."""
    if found.without_interval:
        return f"{found.without_interval} has too few vehicles to say how many seeds would be needed"
    if found.unbounded:
        return f"more seeds would not exclude it if {found.unbounded} is as much worse as measured"
    now = f"{found.now} {'was' if found.now == 1 else 'were'} run"
    return f"about {counted(found.needed or 0, 'seed')} of each scenario would be needed, {now}"


def percent(comparison: Comparison) -> str:
    """Return the stated loss in percent."""
    return f"{100.0 * comparison.loss:g} %"


def _headline(changes: list[MetricChange], better: int) -> str:
    """Return the most important change in words; `better` is 0 for a loss and 1 for a gain."""
    important = list(SAID)
    known = [change for change in changes if change.verdict != "lost"] or changes
    first = min(known, key=lambda change: important.index(change.metric.name) if change.metric.name in SAID else 99)
    name = first.metric.name
    if first.verdict == "lost":
        return f"has no {name}, which BASE has"
    words = SAID.get(name, (f"is worse in {name}", f"is better in {name}"))[better]
    return f"{words}: {_value(first, first.numbers.head)} instead of {_value(first, first.numbers.base)}"


def _value(change: MetricChange, value: float) -> str:
    if math.isnan(value):
        return NONE
    if change.metric.name in PERCENT:
        return f"{100.0 * value:.3g} %"
    return f"{value:.3g}" + ("" if change.metric.unit == "1" else f" {change.metric.unit}")
