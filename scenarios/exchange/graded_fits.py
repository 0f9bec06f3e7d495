"""Grading of a file of fitted rectangles against true boxes, by the metrics `fit.*` of runs."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from luxloop.arrays import Ints
from luxloop.scenarios.document.document import Answer, Document, Paragraph, Section
from luxloop.scenarios.errors import TracksError
from luxloop.scenarios.exchange import file_tables, tabular_boxes
from luxloop.scenarios.exchange.box_table import ANY_AXES, EGO_AXES, BoxTable, Texts
from luxloop.scenarios.exchange.file_formats import read, recognise
from luxloop.scenarios.exchange.paired_frames import (
    BoxLimits,
    FramePairs,
    about_the_ego,
    in_common_axes,
    of_classes,
    outside,
    pair_frames,
    require_common_frames,
)
from luxloop.scenarios.grading import fit_errors, frame_tables
from luxloop.scenarios.grading.figures import Figures
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.observations import RunObservations
from luxloop.scenarios.grading.plane_geometry import iou_table
from luxloop.scenarios.metrics import of_files
from luxloop.scenarios.offline.track_file import read_table, require
from luxloop.scenarios.report.cells import counted
from luxloop.scenarios.report.run_tables import figure_rows
from luxloop.scenarios.run.run_folder import metric_document


@dataclass(frozen=True, slots=True, eq=False)
class GradedFits:
    """Figures of a file of fits by method."""

    pairs: FramePairs
    on_none: int
    """Number of rectangles that overlap no true box."""
    methods: dict[str, Figures]

    @classmethod
    def of(
        cls, truth: Path, fits: Path, truth_format: str | None, classes: tuple[str, ...], limits: BoxLimits
    ) -> "GradedFits":
        """Read both files and compare each rectangle with the true box of the largest overlap.

        Raises
        ------
        TracksError
            A file is not valid, or they do not belong together.
        """
        rectangles, method = read_fits(fits)
        pairs = _paired(read(truth, "truth", truth_format), rectangles, classes, limits)
        true, fit = _matches(pairs)
        graded = ~outside(pairs.truth, limits)[true]
        of_fit = method[pairs.tracks.id[fit].astype(np.int64)]
        found = {
            name: _figures(pairs, true[chosen], fit[chosen])
            for name in dict.fromkeys(method.tolist())
            for chosen in [graded & (of_fit == name)]
        }
        return cls(pairs, len(pairs.tracks) - len(fit), found)


def document(graded: GradedFits) -> dict[str, Any]:
    """Return the figures as JSON."""
    return {
        "file": str(graded.pairs.tracks.source),
        "fits": len(graded.pairs.tracks),
        "on_no_true_box": graded.on_none,
        "methods": {
            name: {metric: metric_document(figure) for metric, figure in figures.items()}
            for name, figures in graded.methods.items()
        },
    }


def report(graded: GradedFits) -> Document:
    """Return the figures as a document, a table for each method."""
    pairs = graded.pairs
    said = f"{counted(len(pairs.tracks), 'fit')}, {graded.on_none} of them on no true box"
    tables = [figure_rows(f"Fits by {method}", figures, figures) for method, figures in graded.methods.items()]
    return Document(
        title=f"{pairs.tracks.source} against {pairs.truth.source}",
        answer=Answer(said),
        lead=[Paragraph(f"{pairs.tracks.source} against {pairs.truth.source}")],
        sections=[Section("fits", "Fits", tables)],
    )


def _paired(truth: list[BoxTable], fits: list[BoxTable], classes: tuple[str, ...], limits: BoxLimits) -> FramePairs:
    boxes = truth if limits.range_max_m is None else about_the_ego(truth)
    tables = in_common_axes(_preferred(boxes), _preferred(fits))
    pairs = pair_frames(*(of_classes(*tables, list(classes)) if classes else tables))
    require_common_frames(pairs)
    return pairs


def _preferred(tables: list[BoxTable]) -> list[BoxTable]:
    """Return the tables about the ego, where a file has one."""
    return [table for table in tables if _is_about_the_ego(table)] or tables


def _is_about_the_ego(table: BoxTable) -> bool:
    """Return True also for axes without a name: rectangles of single frames are in those of the sensor."""
    return table.axes in (*EGO_AXES, ANY_AXES)


def _matches(pairs: FramePairs) -> tuple[Ints, Ints]:
    """Return the rows of true boxes and of the rectangles on them; several may be on one box."""
    found: list[tuple[Ints, Ints]] = [(np.empty(0, np.int64), np.empty(0, np.int64))]
    for true, fit in pairs.steps():
        if len(true):
            overlap = iou_table(pairs.truth.boxes[true], pairs.tracks.boxes[fit])
            on = overlap.max(axis=0) > 0.0
            found.append((true[overlap.argmax(axis=0)[on]], fit[on]))
    return np.concatenate([rows for rows, _ in found]), np.concatenate([rows for _, rows in found])


def _figures(pairs: FramePairs, true: Ints, fit: Ints) -> Figures:
    """Return the figures of some matches, as those of the selected rectangles of a run."""
    graded = np.ones(len(pairs.truth), np.bool_)
    tables = {
        **file_tables.of_stages(),
        "truth": file_tables.truth_table(pairs, graded),
        "fits": _fits(pairs, true, fit),
    }
    about_ego = all(_is_about_the_ego(table) for table in (pairs.truth, pairs.tracks))
    run = RunObservations(tables, GradingConfig(), pairs.frames)
    return Figures(run, {}, of_files.why_no_fit(about_ego, len(fit)), of_files.OF_FITS)


def _fits(pairs: FramePairs, true: Ints, fit: Ints) -> pd.DataFrame:
    """Return the table `fits` of rectangles and the true boxes that they are on, given by their rows."""
    truth = file_tables.truth_table(pairs, np.ones(len(pairs.truth), np.bool_))
    columns = {
        **{name: truth[name].to_numpy()[true] for name in ("frame", "time_s", "actor_id", "range_m", "points")},
        **dict(zip(fit_errors.BOX, pairs.tracks.boxes[fit].T, strict=True)),
        **dict(zip(fit_errors.TRUE_BOX, pairs.truth.boxes[true].T, strict=True)),
        "best": np.ones(len(fit), np.bool_),
    }
    found = fit_errors.errors(file_tables.filled(frame_tables.FITS, columns))
    return found.assign(oracle=False)


METHOD = "method"
"""Column with the name of the method of each rectangle; without it, all are of one."""
ONE_METHOD = "all"


def read_fits(path: Path) -> tuple[list[BoxTable], Texts]:
    """Return the rectangles, once for each frame of reference; their ids are the rows in the method names (N,).

    Raises
    ------
    TracksError
        The file is neither CSV nor Parquet, lacks a column, or has an invalid cell.
    """
    found = recognise(path)
    if found not in ("csv", "parquet"):
        raise TracksError(f"{path}: is of the format {found}; give fits as CSV or Parquet")
    table = read_table(path, parquet=found == "parquet")
    rows = table.drop(columns=["status", *tabular_boxes.IDS], errors="ignore").assign(id=np.arange(len(table)))
    if METHOD not in table:
        return tabular_boxes.boxes_of(path, rows), np.full(len(table), ONE_METHOD)
    cells = table[METHOD]
    require(path, cells, ~cells.isna().to_numpy(np.bool_), "give the name of the method")
    return tabular_boxes.boxes_of(path, rows), np.array([str(cell) for cell in cells], np.str_)
