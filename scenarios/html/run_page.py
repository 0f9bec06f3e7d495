"""The report of one run."""

import json
import re
from dataclasses import dataclass
from pathlib import Path

from scenarios import listing, report_paper, run_folder
from scenarios import report_tables as printed
from scenarios.device import SHIPPED
from scenarios.expect import Check, Limit, Outcome, Verdict, check, verdict
from scenarios.grading.metrics import REGISTRY
from scenarios.html.birdseye import birdseye
from scenarios.html.figure import Figure
from scenarios.html.fit_figures import AGAINST, errors_against, heading_distribution, observations
from scenarios.html.pages import render
from scenarios.html.probabilities import model_probabilities
from scenarios.html.tables import PageTable, page_table
from scenarios.html.timelines import timelines
from scenarios.report import STAGES
from scenarios.report_cells import value_of
from scenarios.result import Metric, Result
from scenarios.worst import WorstFrame, worst_frames

HEADLINES = {
    "track.hota": "HOTA",
    "track.idf1": "IDF1",
    "track.missed": "missed",
    "track.false": "false",
    "track.id_switches": "id switches",
    "fit.best.heading_abs_mean_deg": "heading error",
    "perf.realtime_factor": "x real time",
}
"""Metrics that a run is known by, and what they are called where there is little room."""


ATTENTION: tuple[Outcome, ...] = ("failed", "unexpected pass", "known failure", "passed")
"""In this order expectations are listed."""

IS_DEVICE = re.compile(r"oracle: .*|[\w.]+:[\w.]+")
"""What `luxloop run` can be asked for again; else it is the name of a file of tracks."""


@dataclass(frozen=True, slots=True)
class Run:
    """A run as pages show it."""

    folder: Path
    result: Result
    checks: list[Check]

    @classmethod
    def read(cls, folder: Path) -> "Run":
        """Read a folder that `luxloop run` wrote, and hold it against its own expectations.

        Raises
        ------
        OutputError
            It holds no run.
        """
        result = run_folder.read(folder)
        expect = {name: Limit(**limit) for name, limit in result.config["expect"].items()}
        return cls(folder, result, check(result.metrics, expect))

    @property
    def anchor(self) -> str:
        """Its name in a page."""
        return f"{self.result.scenario}-seed{self.result.seed}"

    @property
    def verdict(self) -> Verdict:
        """As of the run."""
        return verdict(self.checks, self.result.complete)

    @property
    def family(self) -> str:
        """Of a shipped scenario; nothing for one's own."""
        path = listing.paths().get(self.result.scenario)
        return path.parent.name if path else ""

    @property
    def conclusion(self) -> str:
        """The verdict in a sentence."""
        held = sum(check.holds for check in self.checks)
        known = sum(check.outcome == "known failure" for check in self.checks)
        text = f"{held} of {len(self.checks)} expectations hold" if self.checks else "nothing is expected of it"
        text += f", {known} known to fail" if known else ""
        return text if self.result.complete else f"{text} so far; it ended early: {self.result.ended_early}"

    @property
    def headlines(self) -> dict[str, str]:
        """Values that it is known by, by their short names."""
        return {name: with_unit(self.result.metrics[metric]) for metric, name in HEADLINES.items()}

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

    def worst(self, check: Check) -> list[WorstFrame]:
        """Where to look for why an expectation does not hold."""
        return [] if check.holds else worst_frames(self.result, check.name)


def _device_options(device: str) -> str:
    """What to tell `luxloop run` for the same device."""
    if device == SHIPPED:
        return ""
    kind, _, stages = device.partition(": ")
    return "".join(f" --oracle {stage}" for stage in stages.split(", ")) if kind == "oracle" else f" --tracker {device}"


def with_unit(metric: Metric) -> str:
    """The value and its unit."""
    unit = "" if metric.unit in ("1", "count") or metric.value is None else f" {metric.unit}"
    return value_of(metric) + unit


def interval(metric: Metric) -> str:
    """The 95 % interval, nothing where there is none."""
    return "" if metric.interval is None else "{:.3f} to {:.3f}".format(*metric.interval)


def run_page(folder: Path) -> str:
    """Return the page of the run in a folder.

    Raises
    ------
    OutputError
        It holds no run.
    """
    run = Run.read(folder)
    return render(
        "run.html.j2",
        run=run,
        pictures=birdseye(run.result),
        fit_figures=fit_figures(run.result),
        fit_tables=fit_tables(run.result),
        track_figures=[track_figure(run.result)],
        model_figures=[model_probabilities(run.result.tables["tracks"])],
        model_tables=model_tables(run.result),
        stage_tables=stage_tables(run.result),
        config=json.dumps(run.result.config, indent=2, ensure_ascii=False),
        with_unit=with_unit,
        interval=interval,
        registry=REGISTRY,
    )


def fit_figures(result: Result) -> list[Figure]:
    """Figures on single fits."""
    observed = observations(result.tables["fits"], result.tables["truth"])
    return [heading_distribution(result.tables["fits"]), *(errors_against(observed, what) for what in AGAINST)]


def track_figure(result: Result) -> Figure:
    """The timelines."""
    return timelines(result.tables["truth"], result.config["grading"]["hidden_fraction_max"])


def fit_tables(result: Result) -> list[PageTable]:
    """The paper's tables I to III, and the views."""
    tables = (
        report_paper.dataset(result),
        report_paper.heading_error(result),
        report_paper.heading_distribution(result),
        report_paper.heading_by_view(result),
    )
    return [page_table(table) for table in tables]


def model_tables(result: Result) -> list[PageTable]:
    """The paper's table IV, and what is behind it."""
    return [page_table(table(result)) for table in (report_paper.position_error, printed.modes, printed.consistency)]


def stage_tables(result: Result) -> list[PageTable]:
    """Tracking, the stages before it, and speed."""
    tables = [
        printed.one_by_one("Tracking", result, ("track.",)),
        printed.one_by_one("Stages of the tracker", result, STAGES),
        printed.outliers(result),
        *([printed.control(result)] if result.config["control"] else []),
        printed.speed(result),
    ]
    return [page_table(table) for table in tables]
