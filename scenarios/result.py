"""What a run leaves behind: metrics with units and validity, tables, and all that is needed to repeat it."""

from dataclasses import dataclass, field
from typing import Any

import pandas as pd


@dataclass(frozen=True, slots=True)
class Metric:
    """One number. `value` is None where it does not apply, and `reason` then says why."""

    value: float | None
    unit: str
    """"deg", "m", "s", "m/s^2", "ms", "1" for fractions and scores, "count"."""
    n: int
    """Observations behind the value."""
    reason: str = ""
    interval: tuple[float, float] | None = None
    """95 % of the value, by a bootstrap over vehicles; None for counts, and where there are too few vehicles."""


@dataclass(frozen=True, slots=True)
class Result:
    """One graded run."""

    scenario: str
    seed: int
    trace_hash: str
    ended_early: str
    """Why the traffic ended before the scenario's duration; empty when it did not."""
    simulator_failed: bool
    """Whether it ended early because the simulator gave up; else the ego has arrived, or the like."""
    frames: int
    """Frames that were run and graded."""
    metrics: dict[str, Metric]
    tables: dict[str, pd.DataFrame] = field(repr=False)
    """Per-frame tables by name, as in `scenarios/grading/frame_tables.py`."""
    config: dict[str, Any] = field(repr=False)
    """The effective scenario, defaults filled in."""
    versions: dict[str, str] = field(repr=False)

    @property
    def complete(self) -> bool:
        """Whether the run lasted for the scenario's duration."""
        return not self.ended_early
