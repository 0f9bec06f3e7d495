"""Report of a sweep: one self-contained HTML page, and each of its figures as a PNG file."""

from collections.abc import Hashable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from luxloop.scenarios.document import figure_files, html
from luxloop.scenarios.document.document import Answer, Block, Document, Facts, Folded, Paragraph, Section, Table, code
from luxloop.scenarios.document.figure import Figure
from luxloop.scenarios.report.cells import counted
from luxloop.scenarios.study.curves import LEVELS, differences, estimates, measured
from luxloop.scenarios.study.figures import label, picture, text
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
WITHOUT_FAILED = "Means do not include failed runs."
COMBINATIONS = (
    "All combinations of parameters run with the same seeds. A difference compares runs of two curves with the same "
    "seed and the same other parameters; its interval is of the same kind as those of the curve."
)
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
        figure_files.save(one, folder / PICTURES, list(dict.fromkeys(["png", *formats])))
    html.write(folder / REPORT, study_document(sweep, pictures))
    return folder / REPORT


def _picture(study: Study, rows: pd.DataFrame, curve: Curve, name: str) -> Figure:
    make = survival_picture if curve.kind == "survival" else picture
    return make(study, rows, curve, name)


def study_document(sweep: Sweep, pictures: Sequence[Figure]) -> Document:
    """Return a sweep as a document, with these pictures, one for each `[[curve]]`."""
    study, rows = sweep.study, measured(sweep.rows)
    shown = [_with_numbers(sweep, rows, *one) for one in zip(pictures, study.curve, strict=True)]
    first, others = shown[:1], shown[1:]
    broken = failed(study, sweep.rows)
    sections = [
        Section("failed", "Failed runs", [Paragraph(WITHOUT_FAILED), broken] if broken.rows else []),
        Section("curves", "More curves", [block for one in others for block in one]),
        Section("study", "The study", [Paragraph(COMBINATIONS), *_facts(sweep, rows)]),
    ]
    return Document(
        title=study.path.stem,
        answer=Answer(answer(sweep)),
        lead=[*(block for one in first for block in one), Paragraph(study.description)],
        sections=sections,
        name=f"{study.path.stem}: {len(sweep.rows)} runs",
    )


def answer(sweep: Sweep) -> str:
    """Return the range of the first curve, and how many runs have a result."""
    rows = measured(sweep.rows)
    ended = f"{len(rows)} of {counted(sweep.count, 'run')} have a result"
    curves = [curve for curve in sweep.study.curve if curve.kind != "survival"]
    if not curves:
        return ended
    curve = curves[0]
    found = estimates(rows, curve.metric, curve.keys)
    known = found[found["n"] > 0].sort_values("value", kind="stable").to_dict("records")
    name = curve.metric
    if not known:
        return f"No run has a {name}; {ended}"
    low, high = (_point(sweep.study, curve, known[end]) for end in (0, -1))
    return f"{name} is between {low} and {high}; {ended}" if len(known) > 1 else f"{name} is {low}; {ended}"


def _point(study: Study, curve: Curve, row: Mapping[Hashable, Any]) -> str:
    """Return the value of a point, and where it is."""
    definition = study.definition(curve.metric)
    unit = definition.unit if definition else "1"
    where = ", ".join(_with_unit(label(study, key), text(row[key])) for key in curve.keys)
    return f"{row['value']:.3g}{'' if unit in ('1', 'count') else f' {unit}'} ({where})"


def _with_unit(name: str, value: str) -> str:
    """Return the value of a parameter with the unit that its label has in brackets."""
    word, _, unit = name.partition(" [")
    return f"{word} {value} {unit.removesuffix(']')}".rstrip()


def _with_numbers(sweep: Sweep, rows: pd.DataFrame, figure: Figure, curve: Curve) -> list[Block]:
    """Return a figure, and the tables of its numbers and runs, folded."""
    runs = point_runs(sweep.study, rows, curve, sweep.keep_at)
    parts = {"Numbers": numbers(sweep.study, rows, curve), "Runs of each point": runs}
    return [figure, *(Folded(title, [table]) for title, table in parts.items() if table.rows)]


def _facts(sweep: Sweep, rows: pd.DataFrame) -> list[Block]:
    """Return the numbers of runs, and the parameters with their values."""
    study, count = sweep.study, sweep.count
    runs = f"{len(sweep.rows)}" + (f" of {count}" if len(sweep.rows) < count else "")
    status = {str(name): str(number) for name, number in sweep.rows["status"].value_counts().items()}
    seeds, computed = str(len(study.seed_list)), f"{sweep.rows['wall_s'].sum():.0f} s"
    varied = {label(study, one.key): ", ".join(map(text, _values(rows, one.key))) for one in study.vary}
    fixed = {f"{key}, fixed": str(value) for key, value in study.fixed.items()}
    return [
        Facts({"runs": runs, **status, "seeds": seeds, "computed": computed}, large=True),
        Facts({"scenario": code(study.scenario), **varied, **fixed}),
    ]


def numbers(study: Study, rows: pd.DataFrame, curve: Curve) -> Table:
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


def failed(study: Study, rows: pd.DataFrame) -> Table:
    """Return the table of failed and incomplete runs, with their parameters and errors."""
    broken = rows[rows["status"].isin(BROKEN)].head(MOST_FAILED)
    keys = [parameter.key for parameter in study.vary]
    cells = [
        [str(row["index"]), *(text(row[key]) for key in keys), str(row["seed"]), row["status"], row["error"]]
        for row in broken.to_dict("records")
    ]
    head = ["run", *(label(study, key) for key in keys), "seed", "status", "error"]
    return _table("Failed runs", head, cells, left=len(head))


def _table(title: str, head: list[str], lines: list[list[str]], left: int) -> Table:
    """Return a table with the first `left` columns left-aligned and the others right-aligned."""
    table = Table(title)
    for n, name in enumerate(head):
        table.add_column(name, justify="right" if n >= left else "left")
    for line in lines:
        table.add_row(*line)
    return table


def _values(rows: pd.DataFrame, key: str) -> list[object]:
    """Return the values of a parameter, or only the lowest and highest if there are too many."""
    values = list(pd.unique(rows[key]))
    return values if len(values) <= LEVELS else [min(values), "...", max(values)]


def _file_name(number: int, curve: Curve) -> str:
    return f"{number:02d}-{curve.metric.split('.', 1)[1].replace('.', '_')}"
