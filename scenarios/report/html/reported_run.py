"""A run with the derived values that pages show."""

import re
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from luxloop.scenarios.document.document import Answer, Span, Style
from luxloop.scenarios.files import shipped
from luxloop.scenarios.files.expect import SHIPPED, Check, ExpectationOutcome, RunVerdict, ranked, unmet, verdict
from luxloop.scenarios.grading.worst_frames import WorstFrame, worst_frames
from luxloop.scenarios.metrics.main_figures import OF_RUNS
from luxloop.scenarios.report.cells import counted, with_unit
from luxloop.scenarios.result import Result
from luxloop.scenarios.run import run_folder

STYLES: dict[RunVerdict, Style] = {"passed": "good", "failed": "bad", "incomplete": "warn", "no limits": "info"}
OUTCOMES: dict[ExpectationOutcome, Style] = {
    "passed": "good",
    "failed": "bad",
    "known failure": "warn",
    "unexpected pass": "info",
    "not applicable": "dim",
}
NOTHING_EXPECTED = "nothing in [expect] to pass or fail"


def answer(result: Result, checks: Sequence[Check]) -> Answer:
    """Return the verdict with its sentence."""
    found = verdict(checks, result.complete)
    said = _held(checks)
    sentence = said if result.complete else f"ended early: {result.ended_early}; so far {said}"
    return Answer(sentence, found, STYLES[found])


def run_badge(found: RunVerdict) -> Span:
    """Return the verdict on a run as a badge."""
    return Span(found, STYLES[found], badge=True)


def badge(outcome: ExpectationOutcome) -> Span:
    """Return the outcome of an expectation as a badge."""
    return Span(outcome, OUTCOMES[outcome], badge=True)


def _held(checks: Sequence[Check]) -> str:
    if not checks:
        return NOTHING_EXPECTED
    count = {outcome: sum(check.outcome == outcome for check in checks) for outcome in OUTCOMES}
    said = f"{sum(check.holds for check in checks)} of {len(checks)} expectations hold"
    said += f", {count['failed']} failed" if count["failed"] else ""
    said += f", {counted(count['known failure'], 'known failure')}" if count["known failure"] else ""
    return said + (f", {count['not applicable']} not applicable" if count["not applicable"] else "")


IS_DEVICE = re.compile(r"oracle: .*|process:.*|.*\.py:[\w.]+|[\w.]+:[\w.]+|[\w-]+")
"""Devices that `luxloop run` accepts. Other names are files of tracks."""

SHOWN, SEARCHED = 3, 200
"""Worst frames of a metric on a page, and among how many they are chosen."""
APART_S = 1.0
"""Least time between two of them [s]."""


@dataclass(frozen=True, slots=True)
class ReportedRun:
    """A run with the derived values that pages show."""

    folder: Path
    result: Result
    checks: list[Check]
    worst: dict[str, list[WorstFrame]]
    """Worst frames of the metric of each expectation that does not hold."""

    @classmethod
    def read(cls, folder: Path) -> "ReportedRun":
        """Read a run folder.

        Raises
        ------
        OutputError
            The folder has no run.
        """
        return cls.of(run_folder.read(folder), folder)

    @classmethod
    def of(cls, result: Result, folder: Path) -> "ReportedRun":
        """Take a run that was read from its folder, and check its own expectations."""
        checks = result.checks
        worst = {
            check.name: []
            if check.holds or check.metric.not_reported
            else apart(worst_frames(result, check.name, SEARCHED))
            for check in checks
        }
        return cls(folder, result, checks, worst)

    @property
    def verdict(self) -> RunVerdict:
        """Verdict of the run."""
        return verdict(self.checks, self.result.complete)

    @property
    def answer(self) -> Answer:
        """The verdict with its sentence."""
        return answer(self.result, self.checks)

    @property
    def known_failures(self) -> int:
        """Number of known failures among the expectations."""
        return sum(check.outcome == "known failure" for check in self.checks)

    @property
    def family(self) -> str:
        """Family of a shipped scenario; empty for others."""
        path = shipped.paths().get(self.result.scenario)
        return path.parent.name if path else ""

    @property
    def headlines(self) -> dict[str, str]:
        """Values of the main metrics by their short names."""
        return {name: with_unit(self.result.metrics[metric]) for metric, name in OF_RUNS.items()}

    @property
    def unmet(self) -> list[str]:
        """Metrics of the expectations that do not hold, failures before known failures."""
        return [check.name for check in unmet(self.checks)]

    @property
    def commands(self) -> list[str]:
        """Commands that repeat and show the run."""
        result, device = self.result, self.result.config["device"]
        if "recording" in result.config:
            again = f"luxloop track {result.scenario}{_device_options(device)} --out {self.folder}"
            return [again, f"luxloop view {self.folder}"]
        scenario = result.scenario if self.family else f"{result.scenario}.toml"
        settings = "".join(f" --set {shlex.quote(text)}" for text in result.config.get("set", []))
        again = f"luxloop run {scenario} --seed {result.seed}{settings}{_device_options(device)} --out {self.folder}"
        of_tracks = device != SHIPPED and not IS_DEVICE.fullmatch(device)
        return [f"luxloop grade RUN --tracks {device}"] if of_tracks else [again, f"luxloop view {self.folder}"]

    @property
    def ranked(self) -> list[Check]:
        """Expectations by outcome, those farthest beyond their limits first."""
        return ranked(self.checks)


def apart(frames: list[WorstFrame]) -> list[WorstFrame]:
    """Return the first `SHOWN` frames that are `APART_S` apart, so that they show different situations."""
    kept: list[WorstFrame] = []
    for frame in frames:
        if len(kept) < SHOWN and all(abs(frame.time_s - other.time_s) >= APART_S for other in kept):
            kept.append(frame)
    return kept


def _device_options(device: str) -> str:
    """Return the options of `luxloop run` for a device."""
    if device == SHIPPED:
        return ""
    kind, _, stages = device.partition(": ")
    return "".join(f" --oracle {stage}" for stage in stages.split(", ")) if kind == "oracle" else f" --tracker {device}"
