"""Result of a run: metrics with units and validity, tables, and all that is needed to repeat the run."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas as pd  # scenario files are read without it

NOT_REPORTED = "the tracker does not report"
"""Beginning of the reason of metrics of an output that a tracker leaves out, such as a covariance."""


@dataclass(frozen=True, slots=True)
class Metric:
    """A number. `value` is None if the metric does not apply; `reason` then states why."""

    value: float | None
    unit: str
    """"deg", "m", "s", "m/s^2", "ms", "1" for fractions and scores, "count"."""
    n: int
    """Observations behind the value."""
    reason: str = ""
    interval: tuple[float, float] | None = None
    """95 % confidence interval over vehicles; None for counts, and for too few vehicles."""
    why_no_interval: str = ""
    """Why a figure over vehicles has no interval; empty for counts and others that never have one."""

    @property
    def not_reported(self) -> bool:
        """True if the tracker leaves out the output that the metric measures."""
        return self.value is None and self.reason.startswith(NOT_REPORTED)


@dataclass(frozen=True, slots=True)
class Result:
    """A graded run."""

    scenario: str
    seed: int
    trace_hash: str
    ended_early: str
    """Reason why the traffic ended before the scenario's duration; empty if it did not."""
    simulator_failed: bool
    """True if the run ended early because the simulator failed, and not because, say, the ego arrived."""
    frames: int
    """Number of graded frames."""
    metrics: dict[str, Metric]
    tables: "dict[str, pd.DataFrame]" = field(repr=False)
    """Per-frame tables by name, as in `scenarios/grading/frame_tables.py`."""
    config: dict[str, Any] = field(repr=False)
    """The effective scenario, including defaults."""
    versions: dict[str, str] = field(repr=False)
    warnings: tuple[str, ...] = ()
    """Defects of the traffic's input, one line each with consequence and remedy."""

    @property
    def complete(self) -> bool:
        """True if the run lasted for the scenario's duration."""
        return not self.ended_early
