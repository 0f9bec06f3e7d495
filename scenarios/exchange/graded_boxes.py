"""Grading of a file of tracks against a file of true boxes, as a table and as JSON."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.text import Text

from luxloop.scenarios.document.table import Table
from luxloop.scenarios.exchange.box_grading import grade
from luxloop.scenarios.exchange.box_metric_names import AVERAGES, DEFINITIONS, ERRORS, GOSPA, SCORES, Definition
from luxloop.scenarios.exchange.box_table import BoxTable
from luxloop.scenarios.exchange.file_formats import read
from luxloop.scenarios.exchange.paired_frames import (
    BoxLimits,
    FramePairs,
    about_the_ego,
    in_common_axes,
    leave_out,
    of_classes,
    pair_frames,
    require_common_frames,
)
from luxloop.scenarios.report.cells import counted, table_of, value_of
from luxloop.scenarios.result import Metric
from luxloop.scenarios.run.run_folder import metric_document

TABLES = {
    "Tracking": SCORES,
    "GOSPA": GOSPA,
    "Averages over recalls, as nuScenes": AVERAGES,
    "Errors of pairs": ERRORS,
}
"""Titles of the printed tables and their metrics."""


@dataclass(frozen=True, slots=True, eq=False)
class GradedBoxes:
    """Metrics of a file of tracks."""

    pairs: FramePairs
    limits: BoxLimits
    classes: tuple[str, ...]
    """Classes that were graded; empty for all."""
    metrics: dict[str, Metric]
    unknown_classes: tuple[str, ...] = ()
    """Classes of the tracks that the truth does not have, such as misspelt ones."""

    @classmethod
    def of(
        cls,
        truth: Path,
        tracks: Path,
        formats: tuple[str | None, str | None],
        classes: tuple[str, ...],
        limits: BoxLimits,
    ) -> "GradedBoxes":
        """Read both files and grade the tracks.

        Raises
        ------
        TracksError
            A file is not valid, or they do not belong together.
        """
        found = [read(truth, "truth", formats[0]), read(tracks, "tracks", formats[1])]
        if limits.range_max_m is not None:
            found = [about_the_ego(of_file) for of_file in found]
        tables = in_common_axes(found[0], found[1])
        unknown = _unknown_classes(*tables)
        if classes:
            tables = of_classes(*tables, list(classes))
        pairs = pair_frames(*tables)
        require_common_frames(pairs)
        pairs = leave_out(pairs, limits)
        return cls(pairs, limits, classes, grade(pairs, limits), unknown)

    @property
    def warnings(self) -> list[str]:
        """What the numbers do not show."""
        left_out = "left out" if self.classes else "left out of AMOTA and AMOTP"
        names = ", ".join(self.unknown_classes)[:300]
        return [f"the truth has no class {names}: tracks of it are {left_out}"] if names else []


def document(graded: GradedBoxes) -> dict[str, Any]:
    """Return a grading as JSON."""
    pairs = graded.pairs
    return {
        "truth": str(pairs.truth.source),
        "tracks": str(pairs.tracks.source),
        "frames": pairs.frames,
        "true_boxes": len(pairs.truth),
        "track_boxes": len(pairs.tracks),
        "limits": asdict(graded.limits),
        "classes": list(graded.classes),
        "warnings": graded.warnings,
        "metrics": {name: metric_document(metric) for name, metric in graded.metrics.items()},
    }


def report(graded: GradedBoxes) -> Group:
    """Return the printed grading."""
    sections: list[RenderableType] = [
        _header(graded),
        *(Text(f"Warning: {warning}", style="yellow") for warning in graded.warnings),
        *(_table(title, definitions, graded) for title, definitions in TABLES.items()),
        _limits(graded.limits),
    ]
    return Group(*(Padding(section, (0, 0, 1, 0), expand=False) for section in sections))


def _header(graded: GradedBoxes) -> Text:
    pairs = graded.pairs
    of = f", classes {', '.join(graded.classes)}" if graded.classes else ""
    return Text(
        f"{pairs.tracks.source} against {pairs.truth.source}\n"
        f"{counted(pairs.frames, 'frame')}, {counted(len(pairs.truth), 'true box', 'true boxes')}, "
        f"{counted(len(pairs.tracks), 'box', 'boxes')} of tracks{of}"
    )


def _unknown_classes(truth: BoxTable, tracks: BoxTable) -> tuple[str, ...]:
    """Return the classes of tracks that the truth does not have; none if a file has no classes."""
    if truth.kind is None or tracks.kind is None:
        return ()
    return tuple(sorted(set(tracks.kind.tolist()) - set(truth.kind.tolist())))


def _table(title: str, definitions: tuple[Definition, ...], graded: GradedBoxes) -> Table:
    table = table_of(title, "metric", "value", "n")
    table.add_column("", style="dim")
    for name in (definition.name for definition in definitions):
        metric = graded.metrics[name]
        table.add_row(name, value_of(metric), str(metric.n), metric.reason or DEFINITIONS[name].meaning)
    return table


def _limits(limits: BoxLimits) -> Text:
    given = {name: value for name, value in asdict(limits).items() if value is not None}
    return Text("Graded with " + ", ".join(f"{name} = {value:g}" for name, value in given.items()), style="dim")
