"""Run as a document: the printed report, and with figures its page."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from luxloop.scenarios.document.document import (
    Block,
    Document,
    Facts,
    Folded,
    Legend,
    Paragraph,
    Player,
    Preformatted,
    Section,
    Span,
    Table,
    Words,
    code,
)
from luxloop.scenarios.document.figure import Figure
from luxloop.scenarios.files.expect import SHIPPED, Check
from luxloop.scenarios.grading.truth_events.truth_event import COUNTS, EventKind
from luxloop.scenarios.metrics.definitions import find_metric, is_metric
from luxloop.scenarios.report import paper_comparison, run_tables
from luxloop.scenarios.report.cells import interval_of, with_unit
from luxloop.scenarios.report.file_document import file_document
from luxloop.scenarios.report.html.reported_run import ReportedRun, answer, badge
from luxloop.scenarios.report.run_tables import vulnerable
from luxloop.scenarios.result import Result
from luxloop.sim.highway.highway_config import MOTORIST

WORDS = {
    EventKind.EGO_COLLISION: ("collision of the ego", "collisions of the ego"),
    EventKind.OVERLAP: ("overlap", "overlaps"),
    EventKind.TELEPORT: ("teleport", "teleports"),
    EventKind.INSERTION: ("insertion in view", "insertions in view"),
    EventKind.REMOVAL: ("removal in view", "removals in view"),
    EventKind.ID_CHANGE: ("change of id", "changes of id"),
    EventKind.LIMIT_VIOLATION: ("violation of limits", "violations of limits"),
}
"""Singular and plural of each kind."""

DRIVERS, OWN_DRIVERS = "other_vehicles_type", "highway_env"
"""Key of highway-env's configuration that chooses the drivers, and the package of its own."""

VALUES = {
    "overlap_m2": "{:.2g} m²",
    "distance_m": "{:.2g} m",
    "speed_mps": "at {:.2g} m/s",
    "acceleration_mps2": "{:.3g} m/s²",
    "jerk_mps3": "{:.3g} m/s³",
    "yaw_rate_radps": "{:.2g} rad/s",
}
"""Format of each quantity."""


def truth_events(result: Result) -> list[Paragraph]:
    """Return the warnings about the traffic, and a line with the events of each kind; nothing without any."""
    warnings = [Paragraph(f"Warning: {warning}", "warn") for warning in result.warnings]
    events = result.tables.get("events")
    if events is None or events.empty:
        return warnings
    line = f"Traffic events: {'; '.join(_kinds(events))}"
    masked = result.metrics["sim.masked_observations"].value
    if masked:
        line += f"; {masked:.0f} observations are not graded because of them"
    return [*warnings, Paragraph(line + _remedy(result, events), "warn")]


def _remedy(result: Result, events: pd.DataFrame) -> str:
    """Return the remedy for limits that highway-env's own drivers exceed; nothing for other drivers."""
    traffic = result.config.get("traffic", {})
    drivers = traffic.get("config") if traffic.get("kind") == "highway-env" else None
    violated = (events["kind"] == EventKind.LIMIT_VIOLATION.name.lower()).any()
    if drivers is None or not violated or str(drivers.get(DRIVERS, OWN_DRIVERS)).partition(".")[0] != OWN_DRIVERS:
        return ""
    return (
        f'; highway-env\'s own drivers turn and brake harder than cars can: set traffic.config.{DRIVERS} = "{MOTORIST}"'
    )


def _kinds(events: pd.DataFrame) -> Iterator[str]:
    """Yield the number of events of each kind, and the largest of them."""
    for kind in COUNTS.values():
        found = events[events["kind"] == kind.name.lower()]
        if found.empty:
            continue
        largest = found.loc[found["value"].idxmax()]
        actors = " and ".join(name for name in (largest["name"], largest["other"]) if name)
        if kind == EventKind.EGO_COLLISION:
            actors = largest["name"]
        example = f"{actors}, {VALUES[largest['quantity']].format(largest['value'])} at {largest['time_s']:.1f} s"
        yield f"{len(found)} {WORDS[kind][len(found) > 1]} ({'' if len(found) == 1 else 'largest '}{example})"


STAGES = (
    "segmentation.",
    "mma.gain",
    "mma.mode",
    "mma.stationary_acc",
    "mma.switch",
)
"""Prefixes of the metrics of the tracker's stages that no other table shows."""
PICTURE_LEGEND = Legend(
    (
        ("swatch ego", "ego, heading up"),
        ("swatch truth", "true box with a wedge at its front and the vehicle's name; dashed if not graded"),
        ("swatch track", "track with its id, its heading as a line at its front; dashed if coasting"),
        ("swatch false", "false track"),
        ("swatch fit", "fitted rectangle; the fit heading is along its side"),
        ("dot clean", "point on an actor"),
        ("dot ground", "background point"),
        ("dot noise", "noise"),
        ("swatch place", "position of the error"),
    )
)
"""Marks of bird's-eye pictures."""


@dataclass(frozen=True, slots=True)
class RunFigures:
    """Figures of a run by section of its page; none for the printed report."""

    pictures: Sequence[Figure] = ()
    """Bird's-eye pictures, the worst frame first."""
    player: Player | None = None
    fits: Sequence[Figure] = ()
    tracks: Sequence[Figure] = ()
    models: Sequence[Figure] = ()

    @property
    def anchors(self) -> dict[int, str]:
        """Anchors of the pictures by the number of their frame."""
        return {figure.frame: figure.name for figure in self.pictures if figure.frame is not None}


NO_FIGURES = RunFigures()


def run_document(run: ReportedRun, figures: RunFigures = NO_FIGURES) -> Document:
    """Return a run as a document. Without figures it is a text, for which sections of pages are not computed."""
    result = run.result
    if "files" in result.config:
        return file_document(result, figures.tracks)
    first = [*figures.pictures, *figures.tracks][:1]
    more = [figure for figure in figures.pictures if figure not in first]
    bands, again = (run_tables.tracks_by_band(result), _again(run)) if figures is not NO_FIGURES else ([], [])
    sections = [
        Section("expectations", "Expectations", [expectations(run.ranked, run.worst, figures.anchors)]),
        Section("worst", "Worst frames", [PICTURE_LEGEND, *more] if figures.pictures else [], page_only=True),
        Section("frames", "Frame by frame", [figures.player] if figures.player else [], page_only=True),
        Section("fits", "Fits of single frames", [*figures.fits, *_fits(result)]),
        Section(
            "tracks",
            "Tracks",
            [
                *(one for one in figures.tracks if one not in first),
                *run_tables.tracking(result),
                *vulnerable(result),
            ],
        ),
        Section("bands", "Tracks by range, class and view", bands, page_only=True),
        Section("models", "Motion models", [*figures.models, *_models(result)]),
        Section("stages", "All stages", _stages(result)),
        Section("again", "Reproduce", again, page_only=True),
    ]
    return Document(
        title=result.scenario,
        answer=answer(result, run.checks),
        lead=[*first, Facts(run.headlines, large=True), *header(result)],
        sections=sections,
        name=f"{result.scenario}: {run.verdict}",
    )


def header(result: Result) -> list[Block]:
    """Return description, seed, trace hash, a chosen ego, any device but the shipped tracker, and warnings."""
    device, ego = result.config["device"], result.config.get("ego", "")
    selector = result.config.get("traffic", {}).get("ego")  # recordings have no traffic
    chosen = isinstance(selector, str) and selector not in (ego, f"vehicle:{ego}")
    said = f"seed {result.seed}, {result.frames} frames, trace {result.trace_hash}"
    said += f'\nego "{ego}", chosen by ego = "{selector}"' if ego and chosen else ""
    said += "" if device == SHIPPED else f"\ndevice {device}"
    return [
        Paragraph((Span(result.scenario, "bold"), f": {result.config['description']}")),
        *([Paragraph(str(result.config["reason"]), "dim")] if result.config.get("reason") else []),
        Paragraph(said, "dim"),
        *truth_events(result),
    ]


def expectations(
    checks: Sequence[Check], worst: Mapping[str, Sequence[Any]] | None = None, anchors: Mapping[int, str] | None = None
) -> Table:
    """Return the limits of the scenario with values, outcomes, needs, causes, and the worst frames of broken ones.

    Parameters
    ----------
    worst
        Worst frames by the name of the metric.
    anchors
        Anchors of pictures by frame.
    """
    table = Table("Expectations", stacked=True)
    table.add_column("metric", no_wrap=True)
    for name in ("limit", "value", "95 %"):
        table.add_column(name, no_wrap=True)
    table.add_column("", no_wrap=True)
    table.add_column("", style="dim")
    for check in checks:
        meaning = find_metric(check.name).meaning if is_metric(check.name) else ""
        table.add_row(
            Span(check.name, note=meaning),
            str(check.limit),
            with_unit(check.metric),
            interval_of(check.metric),
            badge(check.outcome),
            _why(check, (worst or {}).get(check.name, ()), anchors or {}),
        )
    return table


def _why(check: Check, worst: Sequence[Any], anchors: Mapping[int, str]) -> Words:
    """Return need or cause, and the worst frames with links to their pictures."""
    lines: list[Span] = [Span(check.why)] if check.why else []
    if check.known and check.limit.need:
        lines.insert(0, Span(f"Need: {check.limit.need}"))
    lines += [Span(str(frame), link=f"#{anchors[frame.frame]}" if frame.frame in anchors else "") for frame in worst]
    return tuple(part for number, line in enumerate(lines) for part in ([Span("\n")] if number else []) + [line])


def _fits(result: Result) -> list[Table]:
    """Return the paper's tables I to III, and those of the fits."""
    return [
        paper_comparison.dataset(result),
        paper_comparison.heading_error(result),
        paper_comparison.heading_distribution(result),
        paper_comparison.heading_by_view(result),
        run_tables.heading_by_band(result),
        run_tables.selection(result),
        run_tables.corner_and_extents(result),
    ]


def _models(result: Result) -> list[Table]:
    """Return the paper's table IV, and the tables of modes, predictions and consistency."""
    makers = (paper_comparison.position_error, run_tables.modes, run_tables.predictions, run_tables.consistency)
    return [make(result) for make in makers]


def _stages(result: Result) -> list[Block]:
    """Return the tables of the other stages, speed, and the limits of grading."""
    return [
        *run_tables.emergence(result),
        *run_tables.own_metrics(result),
        run_tables.metric_list("Stages of the tracker", result, STAGES),
        run_tables.outliers(result),
        *([run_tables.control(result)] if result.config["control"] else []),
        run_tables.speed(result),
        run_tables.grading_limits(result.config["grading"]),
    ]


def _again(run: ReportedRun) -> list[Block]:
    """Return the commands that repeat the run, and all that it depends on."""
    result = run.result
    facts: dict[str, Words] = {
        "seed": str(result.seed),
        "frames": str(result.frames),
        "trace hash": code(result.trace_hash),
        "device": code(result.config["device"]),
        **result.versions,
    }
    config = json.dumps(result.config, indent=2, ensure_ascii=False)
    return [
        Preformatted("\n".join(run.commands)),
        Facts(facts),
        Folded("Effective configuration", [Preformatted(config)]),
    ]
