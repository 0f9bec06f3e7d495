"""Expectations of a scenario and the verdict on them."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Literal

from scenarios.grading.metric_names import METRICS
from scenarios.result import Metric

RunVerdict = Literal["passed", "failed", "incomplete"]

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
    """Reason why the expectation fails today. It is shown in every report, and does not fail the run."""

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
        """Return True if the value is within the limits."""
        return (self.min is None or value >= self.min) and (self.max is None or value <= self.max)


@dataclass(frozen=True, slots=True)
class Check:
    """An expectation and the measured metric."""

    name: str
    limit: Limit
    metric: Metric

    @property
    def holds(self) -> bool:
        """True if the metric has a value within the limits; a metric without a value shows nothing."""
        return self.metric.value is not None and self.limit.holds(self.metric.value)

    @property
    def outcome(self) -> ExpectationOutcome:
        """Outcome of the check, considering a known failure.

        An output that the tracker leaves out cannot be right or wrong. Any other metric without a value fails.
        """
        if self.metric.not_reported:
            return "not applicable"
        if self.limit.known_failure:
            return "unexpected pass" if self.holds else "known failure"
        return "passed" if self.holds else "failed"


def metric_name(name: str) -> str:
    """Return `name` if it is the name of a metric.

    Raises
    ------
    ValueError
        It is not; the message names the closest metrics.
    """
    if name not in METRICS:
        close = get_close_matches(name, METRICS, n=3, cutoff=0.5)
        hint = f"did you mean {', '.join(close)}?" if close else "see scenarios/grading/metric_names.py for all names"
        raise ValueError(f"unknown metric; {hint}")
    return name


def check_unit(name: str, limit: Limit) -> None:
    """Check that a limit's unit, if given, is the unit of the metric.

    Raises
    ------
    ValueError
        The units differ.
    """
    if limit.unit and limit.unit != METRICS[name]:
        raise ValueError(f'"{name}".unit = "{limit.unit}": the metric is in "{METRICS[name]}"; convert the limit')


def absent(name: str) -> Metric:
    """Return the metric of a motion model that is not in the filter bank of the run."""
    return Metric(None, METRICS[name], 0, "the run's filter bank has no such model")


def check(metrics: Mapping[str, Metric], expect: Mapping[str, Limit]) -> list[Check]:
    """Check the metrics of a run against the expectations, in the order of the expectations."""
    return [Check(name, limit, metrics.get(name) or absent(name)) for name, limit in expect.items()]


def verdict(checks: Iterable[Check], complete: bool) -> RunVerdict:
    """Return "passed" if no check failed except known failures.

    An incomplete run neither passes nor fails, since its missing frames could change the outcome. A run to which no
    expectation applies fails: it shows nothing.
    """
    if not complete:
        return "incomplete"
    outcomes = [check.outcome for check in checks]
    untested = bool(outcomes) and set(outcomes) == {"not applicable"}
    return "failed" if "failed" in outcomes or untested else "passed"
