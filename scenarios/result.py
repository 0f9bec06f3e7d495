"""Result of a run: metrics with units and validity, tables, and all that is needed to repeat the run."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas as pd  # scenario files are read without it

    from luxloop.scenarios.files.expect import Check, RunVerdict
    from luxloop.scenarios.grading.figures import Figures

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
    """A graded run. What presents or writes it is imported when it is called."""

    scenario: str
    seed: int
    trace_hash: str
    ended_early: str
    """Reason why the traffic ended before the scenario's duration; empty if it did not."""
    simulator_failed: bool
    """True if the run ended early because the simulator failed, and not because, say, the ego arrived."""
    frames: int
    """Number of graded frames."""
    metrics: "Figures"
    """Metrics by name; one with other filters is computed from the tables when it is asked for."""
    tables: "dict[str, pd.DataFrame]" = field(repr=False)
    """Per-frame tables by name, as in `scenarios/grading/frame_tables.py`."""
    config: dict[str, Any] = field(repr=False)
    """The effective scenario, including defaults."""
    versions: dict[str, str] = field(repr=False)
    warnings: tuple[str, ...] = ()
    """Defects of the traffic's input, one line each with consequence and remedy."""
    out: Path | None = None
    """Folder of the run; None if it is in memory only."""

    @property
    def complete(self) -> bool:
        """True if the run lasted for the scenario's duration."""
        return not self.ended_early

    @property
    def checks(self) -> "list[Check]":
        """The expectations of the scenario with the measured metrics, in their order."""
        from luxloop.scenarios.files.expect import Limit, check

        expect = {name: Limit(**limit) for name, limit in self.config["expect"].items()}
        return check(self.metrics, expect, self.config["device"])

    @property
    def verdict(self) -> "RunVerdict":
        """Verdict on the expectations."""
        from luxloop.scenarios.files.expect import verdict

        return verdict(self.checks, self.complete)

    def report(self) -> str:
        """Return the report as text without colours, as in `report.txt` of a run folder."""
        from luxloop.scenarios.report import text

        return text.as_text(text.report(self, self.checks))

    def save(self, out: str | Path) -> "Result":
        """Write the folder of the run, without recording and scans; return the result with this folder as `out`.

        Raises
        ------
        OutputError
            The folder cannot be written, or holds other files than those of an earlier run.
        """
        from luxloop.scenarios.run import run_folder

        with run_folder.create(Path(out)) as folder:
            run_folder.write(folder, self, self.checks, self.report())
        return replace(self, out=Path(out))

    def _repr_html_(self) -> str:
        """Return verdict, unmet expectations and main metrics as HTML, for notebooks."""
        from luxloop.scenarios.report.text import result_html

        return result_html(self)
