"""A run as pages show it."""

import re
from dataclasses import dataclass
from pathlib import Path

from scenarios.files import shipped
from scenarios.files.expect import Check, ExpectationOutcome, Limit, RunVerdict, check, verdict
from scenarios.grading.worst_frames import WorstFrame, worst_frames
from scenarios.report.cells import unit_of, value_of
from scenarios.result import Metric, Result
from scenarios.run import run_folder
from scenarios.run.device import SHIPPED

SUITE_METRICS = {
    "track.hota": "HOTA",
    "track.idf1": "IDF1",
    "track.missed": "missed",
    "track.false": "false",
    "track.id_switches": "id switches",
    "fit.best.heading_abs_mean_deg": "heading error",
    "perf.realtime_factor": "x real time",
}
"""Metrics that a run is known by, and what they are called where there is little room."""

ATTENTION: tuple[ExpectationOutcome, ...] = ("failed", "unexpected pass", "known failure", "passed")
"""In this order expectations are listed."""

IS_DEVICE = re.compile(r"oracle: .*|[\w.]+:[\w.]+")
"""What `luxloop run` can be asked for again; else it is the name of a file of tracks."""


@dataclass(frozen=True, slots=True)
class ReportedRun:
    """A run as pages show it."""

    folder: Path
    result: Result
    checks: list[Check]
    worst: dict[str, list[WorstFrame]]
    """Where to look for why an expectation does not hold, by its metric."""

    @classmethod
    def read(cls, folder: Path) -> "ReportedRun":
        """Read a folder that `luxloop run` wrote, and hold it against its own expectations.

        Raises
        ------
        OutputError
            It holds no run.
        """
        result = run_folder.read(folder)
        expect = {name: Limit(**limit) for name, limit in result.config["expect"].items()}
        checks = check(result.metrics, expect)
        worst = {one.name: [] if one.holds else worst_frames(result, one.name) for one in checks}
        return cls(folder, result, checks, worst)

    @property
    def verdict(self) -> RunVerdict:
        """As of the run."""
        return verdict(self.checks, self.result.complete)

    @property
    def known(self) -> int:
        """Expectations that do not hold and are known not to."""
        return sum(check.outcome == "known failure" for check in self.checks)

    @property
    def family(self) -> str:
        """Of a shipped scenario; nothing for one's own."""
        path = shipped.paths().get(self.result.scenario)
        return path.parent.name if path else ""

    @property
    def conclusion(self) -> str:
        """The verdict in a sentence."""
        held = sum(check.holds for check in self.checks)
        text = f"{held} of {len(self.checks)} expectations hold" if self.checks else "nothing is expected of it"
        text += f", {self.known} known to fail" if self.known else ""
        return text if self.result.complete else f"{text} so far; it ended early: {self.result.ended_early}"

    @property
    def headlines(self) -> dict[str, str]:
        """Values that it is known by, by their short names."""
        return {name: with_unit(self.result.metrics[metric]) for metric, name in SUITE_METRICS.items()}

    @property
    def unmet(self) -> list[str]:
        """Metrics that do not do what is expected of them, failures before known ones."""
        return [check.name for check in self.ranked if not check.holds]

    @property
    def commands(self) -> list[str]:
        """How to do it again, and to watch it."""
        result, device = self.result, self.result.config["device"]
        scenario = result.scenario if self.family else f"{result.scenario}.toml"
        again = f"luxloop run {scenario} --seed {result.seed}{_device_options(device)} --out {self.folder}"
        of_tracks = device != SHIPPED and not IS_DEVICE.fullmatch(device)
        return [f"luxloop grade RUN --tracks {device}"] if of_tracks else [again, f"luxloop view {self.folder}"]

    @property
    def ranked(self) -> list[Check]:
        """Expectations, those that want a look first."""
        return sorted(self.checks, key=lambda check: ATTENTION.index(check.outcome))


def _device_options(device: str) -> str:
    """What to tell `luxloop run` for the same device."""
    if device == SHIPPED:
        return ""
    kind, _, stages = device.partition(": ")
    return "".join(f" --oracle {stage}" for stage in stages.split(", ")) if kind == "oracle" else f" --tracker {device}"


def with_unit(metric: Metric) -> str:
    """The value and its unit."""
    return value_of(metric) + ("" if metric.value is None else unit_of(metric))


def interval(metric: Metric) -> str:
    """The 95 % interval, nothing where there is none."""
    return "" if metric.interval is None else "{:.3f} to {:.3f}".format(*metric.interval)
