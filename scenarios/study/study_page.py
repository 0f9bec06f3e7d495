"""Report of a sweep: one self-contained HTML page, and each of its figures as a PNG file."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from luxloop.scenarios.report import figure_files
from luxloop.scenarios.report.html import pages
from luxloop.scenarios.report.html.page_tables import Cell, PageTable, Row
from luxloop.scenarios.study.curves import LEVELS, differences, estimates, measured
from luxloop.scenarios.study.figures import Picture, label, picture, text
from luxloop.scenarios.study.study_file import Curve, Study
from luxloop.scenarios.study.study_tables import (
    estimate_cells,
    estimate_head,
    interval_cells,
    kind_of,
    point_runs,
    survival_lines,
)
from luxloop.scenarios.study.survival_picture import survival_picture
from luxloop.scenarios.study.sweep_runs import Sweep
from luxloop.scenarios.study.worker import BROKEN

REPORT = "report.html"
PICTURES = "pictures"
MOST_FAILED = 100
"""Maximum number of failed runs listed on the page; the rows hold all of them."""


def report(sweep: Sweep, folder: Path, formats: Sequence[str] = ()) -> Path:
    """Write `report.html` and `pictures/*.png` into a folder, pictures also in further formats; return the page.

    Raises
    ------
    OutputError
        The folder cannot be written.
    """
    study, rows = sweep.study, measured(sweep.rows)
    pictures = [_picture(study, rows, curve, _file_name(number, curve)) for number, curve in enumerate(study.curve, 1)]
    figure_files.make_folder(folder / PICTURES)
    for one in pictures:
        one.save(folder / PICTURES, list(dict.fromkeys(["png", *formats])))
    pages.write(folder / REPORT, page(sweep, pictures))
    return folder / REPORT


def _picture(study: Study, rows: pd.DataFrame, curve: Curve, name: str) -> Picture:
    make = survival_picture if curve.kind == "survival" else picture
    return make(study, rows, curve, name)


def page(sweep: Sweep, pictures: list[Picture]) -> str:
    """Return the HTML page of a sweep with these pictures, one for each `[[curve]]`."""
    study, rows = sweep.study, measured(sweep.rows)
    return pages.render(
        "study.html.j2",
        name=study.path.stem,
        study=study,
        sweep=sweep,
        status=sweep.rows["status"].value_counts().to_dict(),
        parameters=[
            (label(study, parameter.key), ", ".join(map(text, _values(rows, parameter.key))))
            for parameter in study.vary
        ],
        shown=[
            (one.figure(), numbers(study, rows, curve), point_runs(study, rows, curve, sweep.keep_at))
            for one, curve in zip(pictures, study.curve, strict=True)
        ],
        failed=failed(study, sweep.rows),
        wall_s=float(sweep.rows["wall_s"].sum()),
    )


def numbers(study: Study, rows: pd.DataFrame, curve: Curve) -> PageTable:
    """Return the table of a figure's numbers, with differences from its first curve, or tests against it."""
    if curve.kind == "survival":
        head, lines = survival_lines(study, rows, curve)
        return _table(f"Numbers: {label(study, curve.metric)}", head, lines, left=len(curve.keys))
    found = estimates(rows, curve.metric, curve.keys)
    definition = study.definition(curve.metric)
    kind = kind_of(rows, curve.metric, definition.unit if definition else "")
    head = [*(label(study, key) for key in curve.keys), *estimate_head(kind)]
    cells = [[*(text(row[key]) for key in curve.keys), *estimate_cells(row, kind)] for row in found.to_dict("records")]
    if curve.by and 0 < rows[curve.by].nunique() <= LEVELS and study.samples is None:
        first = found[curve.by].cat.categories[0]
        change = differences(rows, curve.metric, curve.keys, curve.by, [parameter.key for parameter in study.vary])
        of = {tuple(row[key] for key in curve.keys): row for row in change.to_dict("records")}
        head += [f"minus {text(first)}", "95 %"]
        for line, row in zip(cells, found.to_dict("records"), strict=True):
            group = tuple(row[key] for key in curve.keys)
            line += interval_cells(of[group]) if group in of else ["", ""]
    return _table(f"Numbers: {label(study, curve.metric)}", head, cells, left=len(curve.keys))


def failed(study: Study, rows: pd.DataFrame) -> PageTable:
    """Return the table of failed and incomplete runs, with their parameters and errors."""
    broken = rows[rows["status"].isin(BROKEN)].head(MOST_FAILED)
    keys = [parameter.key for parameter in study.vary]
    cells = [
        [str(row["index"]), *(text(row[key]) for key in keys), str(row["seed"]), row["status"], row["error"]]
        for row in broken.to_dict("records")
    ]
    head = ["run", *(label(study, key) for key in keys), "seed", "status", "error"]
    return _table("Failed runs", head, cells, left=len(head))


def _table(title: str, head: list[str], lines: list[list[str]], left: int) -> PageTable:
    """Return a table with the first `left` columns left-aligned and the others right-aligned."""
    rows = [Row([Cell(cell, n >= left) for n, cell in enumerate(line)], "") for line in lines]
    return PageTable(title, [Cell(cell, n >= left) for n, cell in enumerate(head)], rows)


def _values(rows: pd.DataFrame, key: str) -> list[object]:
    """Return the values of a parameter, or only the lowest and highest if there are too many."""
    values = list(pd.unique(rows[key]))
    return values if len(values) <= LEVELS else [min(values), "...", max(values)]


def _file_name(number: int, curve: Curve) -> str:
    return f"{number:02d}-{curve.metric.split('.', 1)[1].replace('.', '_')}"
