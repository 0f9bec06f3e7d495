"""Expectations of a scenario and the verdict on them.

The text of a known failure begins with a figure, which excuses a range of values. The range lies around the figure of
the run, as in any measurement with a tolerance. It is wide enough for small changes of the tracker, and so narrow that
a clear loss leaves it:

- counts: the larger of 2 and 30 %, because rare events are nearly Poisson distributed, with a standard deviation of the
  square root of the count;
- shares and scores: 10 % of the value or of its complement, whichever is smaller, but at least 0.01;
- other units: 10 %.
"""

import math
import re
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Literal

from luxloop.scenarios.metrics.definitions import find_metric
from luxloop.scenarios.metrics.own_metric import PREFIX, OwnMetric, definitions_of
from luxloop.scenarios.result import Metric

COUNT, SHARE = "count", "1"
"""Units with rules of their own."""

_FIGURE = re.compile(r"\s*([-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?)\s*:\s*(?=\S)")


def figure_of(text: str) -> float | None:
    """Return the figure of a text `FIGURE: CAUSE`, None if it has none."""
    found = _FIGURE.match(text)
    return float(found[1]) if found else None


def cause_of(text: str) -> str:
    """Return a text `FIGURE: CAUSE` without its figure."""
    return _FIGURE.sub("", text, count=1)


def tolerance(figure: float, unit: str) -> float:
    """Return how far a value may be from the figure, in the metric's unit."""
    if unit == COUNT:
        return max(2.0, 0.3 * abs(figure))
    if unit == SHARE:
        return max(0.01, 0.1 * min(abs(figure), abs(1.0 - figure)))
    return 0.1 * abs(figure)


def worst_values(figure: float | None, smallest: float | None, largest: float | None, unit: str) -> tuple[float, float]:
    """Return the smallest and the largest excused value.

    Parameters
    ----------
    figure
        Of the known failure; None excuses any value.
    smallest, largest
        Limits of the expectation; the range begins at the limit if the figure holds. None: no such limit.
    unit
        Unit of the metric.
    """
    if figure is None:
        return -math.inf, math.inf
    spread = tolerance(figure, unit)
    low = -math.inf if smallest is None else min(figure, smallest) - spread
    high = math.inf if largest is None else max(figure, largest) + spread
    return low, high


RunVerdict = Literal["passed", "failed", "incomplete", "no limits"]

SHIPPED = "luxloop.tracker.tracker:Tracker"
"""Name of the shipped tracker."""

ExpectationOutcome = Literal["passed", "failed", "known failure", "unexpected pass", "not applicable"]


@dataclass(frozen=True, slots=True)
class Limit:
    """Range of allowed values of a metric, both ends included."""

    min: float | None = None
    """Smallest value that passes, in the metric's unit."""
    max: float | None = None
    """Largest value that passes, in the metric's unit."""
    unit: str = ""
    """Unit of the limits, for readers; must be the unit of the metric."""
    need: str = ""
    """Requirement or source behind the limit."""
    known_failure: str = ""
    """`FIGURE: CAUSE`, why the expectation fails today. It is shown in every report. Values up to the figure and a
    tolerance do not fail the run; without a figure, or with another seed or duration, no value does."""
    known_failure_of: str = SHIPPED
    """The tracker that has the known failure, as `--tracker` names it. Any other one fails."""

    def __post_init__(self) -> None:
        if self.min is None and self.max is None:
            raise ValueError("no limit: give min, max or both")
        if self.min is not None and self.max is not None and self.min > self.max:
            raise ValueError(f"min = {self.min} is above max = {self.max}: no value can pass; swap them")

    def __str__(self) -> str:
        low = [] if self.min is None else [f">= {self.min:g}"]
        high = [] if self.max is None else [f"<= {self.max:g}"]
        return ", ".join(low + high)

    def without_figure(self) -> "Limit":
        """Return the limit of a run whose figures are other ones, for example because of its seed."""
        return replace(self, known_failure=cause_of(self.known_failure))

    def holds(self, value: float) -> bool:
        """Return True if the value is within the limits."""
        return (self.min is None or value >= self.min) and (self.max is None or value <= self.max)


@dataclass(frozen=True, slots=True)
class Check:
    """An expectation and the measured metric."""

    name: str
    limit: Limit
    metric: Metric
    device: str = SHIPPED
    """The tracker of the run."""

    @property
    def known(self) -> bool:
        """True if the tracker of the run is known to fail."""
        return bool(self.limit.known_failure) and self.device == self.limit.known_failure_of

    @property
    def worst_known(self) -> tuple[float, float]:
        """The smallest and the largest value that the known failure excuses."""
        figure = figure_of(self.limit.known_failure)
        return worst_values(figure, self.limit.min, self.limit.max, self.metric.unit)

    @property
    def why(self) -> str:
        """The reason of the outcome, or else the requirement, for reports."""
        if not self.known:
            return self.metric.reason or self.limit.need
        low, high = self.worst_known
        ends = [f"down to {low:.4g}"] * math.isfinite(low) + [f"up to {high:.4g}"] * math.isfinite(high)
        worse = f"worse than its known failure ({' and '.join(ends)}): " if self.outcome == "failed" else ""
        return self.metric.reason or worse + self.limit.known_failure

    @property
    def holds(self) -> bool:
        """True if the metric has a value within the limits; a metric without a value shows nothing."""
        return self.metric.value is not None and self.limit.holds(self.metric.value)

    @property
    def excess(self) -> float:
        """Distance of the value beyond the limits, in units of the tolerance of known failures; 0 without a value."""
        value, limit = self.metric.value, self.limit
        if value is None or self.holds:
            return 0.0
        end = limit.min if limit.min is not None and value < limit.min else limit.max
        assert end is not None  # the value is above it
        return abs(value - end) / max(tolerance(end, self.metric.unit), sys.float_info.min)

    @property
    def outcome(self) -> ExpectationOutcome:
        """Outcome of the check, considering a known failure.

        An output that the tracker leaves out cannot be right or wrong. Any other metric without a value fails.
        """
        if self.metric.not_reported:
            return "not applicable"
        if self.holds:
            return "unexpected pass" if self.known else "passed"
        return "known failure" if self.known and self._excused else "failed"

    @property
    def _excused(self) -> bool:
        low, high = self.worst_known
        if self.metric.value is None:
            return not (math.isfinite(low) or math.isfinite(high))
        return low <= self.metric.value <= high


def metric_name(name: str) -> str:
    """Return `name` if it is the name of a shipped metric, or begins like that of an own one.

    Raises
    ------
    ValueError
        It is not; the message names the closest metrics.
    """
    if not name.startswith(PREFIX):
        find_metric(name)
    return name


def unit_of(name: str, own: Iterable[OwnMetric]) -> str:
    """Return the unit of a shipped or own metric.

    Raises
    ------
    ValueError
        No `[[metric]]` has this name.
    """
    if not name.startswith(PREFIX):
        return find_metric(name).unit
    known = definitions_of(own)
    if name not in known:
        there = f"name one of {', '.join(known)}, or add it" if known else "add it"
        raise ValueError(f"{name}: no [[metric]] of this file has this name; {there}")
    return known[name].unit


def check_unit(name: str, limit: Limit, own: Iterable[OwnMetric] = ()) -> None:
    """Check that a limit's unit, if given, is the unit of the metric.

    Raises
    ------
    ValueError
        The units differ, or the metric is not defined.
    """
    unit = unit_of(name, own)
    if limit.unit and limit.unit != unit:
        raise ValueError(f'"{name}".unit = "{limit.unit}": the metric is in "{unit}"; convert the limit')


def absent(name: str) -> Metric:
    """Return the own metric of another scenario file."""
    return Metric(None, "", 0, f"the run has no metric {name}; run the scenario again")


def check(metrics: Mapping[str, Metric], expect: Mapping[str, Limit], device: str = SHIPPED) -> list[Check]:
    """Check the metrics of a run of the tracker `device` against the expectations, in the order of the expectations."""
    return [Check(name, limit, metrics.get(name) or absent(name), device) for name, limit in expect.items()]


OUTCOME_ORDER: tuple[ExpectationOutcome, ...] = (
    "failed",
    "unexpected pass",
    "known failure",
    "passed",
    "not applicable",
)
"""Order of expectations in a list."""


def ranked(checks: Iterable[Check]) -> list[Check]:
    """Return the checks in the order of `OUTCOME_ORDER`, those farthest beyond their limits first."""
    return sorted(checks, key=lambda check: (OUTCOME_ORDER.index(check.outcome), -check.excess))


def unmet(checks: Iterable[Check]) -> list[Check]:
    """Return the checks that do not hold, failures before known failures, those farthest beyond their limits first."""
    return [check for check in ranked(checks) if check.outcome in ("failed", "known failure")]


def verdict(checks: Iterable[Check], complete: bool) -> RunVerdict:
    """Return "passed" if no check failed except known failures, "no limits" without any check.

    An incomplete run neither passes nor fails, since its missing frames could change the outcome. A run with
    expectations of which none applies or has an observation fails: it shows nothing.
    """
    if not complete:
        return "incomplete"
    found = [(check.outcome, check.metric.n) for check in checks]
    if not found:
        return "no limits"
    tested = any(outcome != "not applicable" and observations for outcome, observations in found)
    return "passed" if tested and all(outcome != "failed" for outcome, _ in found) else "failed"


def exit_code(outcome: RunVerdict) -> int:
    """Return the exit code of a verdict: 1 if an expectation failed or the run is incomplete, else 0."""
    return int(outcome in ("failed", "incomplete"))
