"""Expectations of a scenario, and the verdict on them."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Literal

from scenarios.grading.metric_names import METRICS
from scenarios.result import Metric

RunVerdict = Literal["passed", "failed", "incomplete"]

ExpectationOutcome = Literal["passed", "failed", "known failure", "unexpected pass"]


@dataclass(frozen=True, slots=True)
class Limit:
    """What a metric must keep to; both ends are allowed values."""

    min: float | None = None
    """Smallest value that passes, in the metric's unit."""
    max: float | None = None
    """Largest value that passes, in the metric's unit."""
    unit: str = ""
    """The metric's unit, for readers; another one than the metric's is refused."""
    need: str = ""
    """Who needs this value, or where it comes from."""
    known_failure: str = ""
    """Why it does not hold today. It stays in every report, and does not fail the run."""

    def __post_init__(self) -> None:
        if self.min is None and self.max is None:
            raise ValueError("no limit: give min, max or both")
        if self.min is not None and self.max is not None and self.min > self.max:
            raise ValueError(f"min = {self.min} is above max = {self.max}: no value can pass; swap them")

    def __str__(self) -> str:
        low = [] if self.min is None else [f">= {self.min:g}"]
        high = [] if self.max is None else [f"<= {self.max:g}"]
        return ", ".join(low + high)

    def holds(self, value: float) -> bool:
        """Whether the value keeps to the limit."""
        return (self.min is None or value >= self.min) and (self.max is None or value <= self.max)


@dataclass(frozen=True, slots=True)
class Check:
    """One expectation beside what came out."""

    name: str
    limit: Limit
    metric: Metric

    @property
    def holds(self) -> bool:
        """A metric without a value does not hold: what was to be shown was not shown."""
        return self.metric.value is not None and self.limit.holds(self.metric.value)

    @property
    def outcome(self) -> ExpectationOutcome:
        """What came out, in the light of what is known."""
        if self.limit.known_failure:
            return "unexpected pass" if self.holds else "known failure"
        return "passed" if self.holds else "failed"


def metric_name(name: str) -> str:
    """Return `name` if there is such a metric.

    Raises
    ------
    ValueError
        There is none; the message names the closest.
    """
    if name not in METRICS:
        close = get_close_matches(name, METRICS, n=3, cutoff=0.5)
        hint = f"did you mean {', '.join(close)}?" if close else "see scenarios/grading/metric_names.py for all names"
        raise ValueError(f"unknown metric; {hint}")
    return name


def check_unit(name: str, limit: Limit) -> None:
    """Hold a limit's unit, if it names one, against the metric's.

    Raises
    ------
    ValueError
        It is another one.
    """
    if limit.unit and limit.unit != METRICS[name]:
        raise ValueError(f'"{name}".unit = "{limit.unit}": it is in "{METRICS[name]}"; convert the limit')


def check(metrics: Mapping[str, Metric], expect: Mapping[str, Limit]) -> list[Check]:
    """Hold a run's metrics against the expectations, in their order."""
    return [Check(name, limit, metrics[name]) for name, limit in expect.items()]


def verdict(checks: Iterable[Check], complete: bool) -> RunVerdict:
    """Say whether no check failed, but for known failures.

    An incomplete run shows neither: what is missing could have gone either way.
    """
    if not complete:
        return "incomplete"
    return "failed" if any(check.outcome == "failed" for check in checks) else "passed"
