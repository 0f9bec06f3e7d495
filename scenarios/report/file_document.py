"""Grading of tracks in a file against true boxes as a document: the printed report, and with figures its page."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from luxloop.scenarios.document.document import Answer, Block, Document, Facts, Paragraph, Section, Table
from luxloop.scenarios.document.figure import Figure
from luxloop.scenarios.metrics.definitions import RANGE_BANDS, find_metric
from luxloop.scenarios.metrics.main_figures import OF_FILES
from luxloop.scenarios.report.cells import counted, percent_of, table_of, value_of, with_unit
from luxloop.scenarios.report.run_tables import band_label, figure_rows, grading_limits
from luxloop.scenarios.result import Result

TABLES = {
    "Tracking": ("score",),
    "Found and missed objects": ("vehicle", "confirmation"),
    "GOSPA": ("gospa",),
    "Averages over recalls, as nuScenes": ("recall",),
    "Errors of pairs": ("track",),
    "Boxes": ("dataset",),
}
"""Titles of the tables, and the kinds of their metrics."""
BANDED = {
    "track.hota": "HOTA",
    "track.mota": "MOTA",
    "track.missed_share": "missed",
    "track.false_share": "false",
    "track.gospa_m": "GOSPA [m]",
    "track.position_abs_mean_m": "position [m]",
    "track.orientation_abs_mean_deg": "heading [deg]",
    "track.velocity_abs_mean_mps": "velocity [m/s]",
}
"""Metrics that are given by class and by range, too, with the titles of their columns."""


def file_document(result: Result, figures: Sequence[Figure] = ()) -> Document:
    """Return a grading of files as a document."""
    first, more = figures[:1], figures[1:]
    files, missing = result.config["files"], without_value(result)
    sections = [
        Section("tracks", "Tracks", [*more, *tables(result)]),
        Section("bands", "By class and range", by_band(result)),
        Section("scenes", "By scene", by_scene(files.get("scenes") or {})),
        Section("missing", "Metrics without a value", missing),
        Section("limits", "Limits", [grading_limits(files["limits"])]),
    ]
    return Document(
        title=f"{Path(result.config['device']).name} on {result.scenario}",
        answer=answer(result),
        lead=[
            Paragraph(_header(result)),
            *(Paragraph(f"Warning: {warning}", "warn") for warning in result.warnings),
            *first,
            Facts({name: with_unit(result.metrics[metric]) for metric, name in OF_FILES.items()}, large=True),
        ],
        sections=sections,
    )


def answer(result: Result) -> Answer:
    """Return what the tracks miss and add, in one sentence."""
    metrics, run = result.metrics, result.metrics.run
    missed, false, hota = (metrics[f"track.{name}"] for name in ("missed_share", "false", "hota"))
    if missed.value is None:
        return Answer("The truth has no graded boxes")
    boxes, tracks = counted(len(run.vehicle), "true box", "true boxes"), len(run.clear.tracks)
    said = f"The tracks miss {percent_of(missed)} of {boxes}"
    said += f", and {value_of(false)} of their {tracks} boxes hit none" if tracks else "; there are none"
    return Answer(f"{said}; HOTA is {value_of(hota)}")


def bands(result: Result) -> list[dict[str, str]]:
    """Return the filters by the classes of the truth, and by range, as far as they are known."""
    missing, kinds = result.config["missing"], result.metrics.run.vehicle.table["kind"]
    of_class = [] if "class" in missing else [{"class": name} for name in sorted(set(kinds))]
    return of_class if "range" in missing else [*of_class, *({"range": band} for band in RANGE_BANDS)]


def tables(result: Result) -> list[Table]:
    """Return a table for each group of metrics with a value."""
    known = [name for name, metric in result.metrics.items() if metric.value is not None]
    names = {
        title: [name for name in known if find_metric(name).definition.kind in kinds] for title, kinds in TABLES.items()
    }
    return [figure_rows(title, result.metrics, rows) for title, rows in names.items() if rows]


def by_band(result: Result) -> list[Block]:
    """Return the table by class and by range; none if the files have neither."""
    filters = bands(result)
    if not filters:
        return []
    table = table_of("By class and range", "", *BANDED.values(), "n")
    for band in filters:
        metrics = [result.metrics.where(name, **band) for name in BANDED]
        table.add_row(band_label(band), *map(value_of, metrics), str(metrics[0].n))
    return [table]


def by_scene(scenes: Mapping[str, Mapping[str, float | None]]) -> list[Block]:
    """Return the table of the main figures by scene; none for files without scenes."""
    table = table_of("By scene", "", *OF_FILES.values())
    for scene, figures in scenes.items():
        table.add_row(scene, *("-" if value is None else f"{value:.3g}" for value in figures.values()))
    return [table] if scenes else []


def without_value(result: Result) -> list[Block]:
    """Return the table of the metrics without a value, by the reason."""
    reasons: dict[str, list[str]] = {}
    for name, metric in result.metrics.items():
        if metric.value is None:
            reasons.setdefault(metric.reason, []).append(name)
    table = Table("Metrics without a value", stacked=True)
    table.add_column("reason")
    table.add_column("metrics", style="dim")
    for reason, names in reasons.items():
        table.add_row(reason, ", ".join(names))
    return [table] if reasons else []


def _header(result: Result) -> str:
    run, files = result.metrics.run, result.config["files"]
    of = f", classes {', '.join(files['classes'])}" if files["classes"] else ""
    return (
        f"{result.config['device']} against {files['truth']}\n"
        f"{counted(result.frames, 'frame')}, {counted(len(run.vehicle), 'true box', 'true boxes')}, "
        f"{counted(len(run.clear.tracks), 'box', 'boxes')} of tracks{of}"
    )
