"""Report of a sweep: one self-contained HTML page, and each of its figures as a PNG file."""

import math
from collections.abc import Hashable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import pandas as pd

from luxloop.scenarios.document import html
from luxloop.scenarios.document.document import (
    Answer,
    Block,
    Document,
    Facts,
    Folded,
    Paragraph,
    Section,
    Span,
    Table,
    code,
)
from luxloop.scenarios.document.figure import Figure, make_folder
from luxloop.scenarios.metrics.definitions import SURVIVAL, survival_measure
from luxloop.scenarios.report.cells import counted
from luxloop.scenarios.statistics.intervals import FEWEST_SEEDS
from luxloop.scenarios.study import survival
from luxloop.scenarios.study.curves import LEVELS, differences, estimates, groups, is_binary, measured
from luxloop.scenarios.study.figures import label, picture, text
from luxloop.scenarios.study.study_file import Curve, Study
from luxloop.scenarios.study.survival import survival_picture
from luxloop.scenarios.study.sweep_runs import Sweep
from luxloop.scenarios.study.worker import BROKEN

Kind = Literal["share", "count", "quantity"]


def kind_of(rows: pd.DataFrame, metric: str, unit: str) -> Kind:
    """Return the kind of a metric: a share of runs, a count, or any other quantity."""
    if is_binary(rows[metric]):
        return "share"
    return "count" if unit == "count" else "quantity"


def estimate_head(kind: Kind) -> list[str]:
    """Return the names of the columns."""
    if kind == "share":
        return ["share", "95 %", "runs"]
    return ["median", "95 %", "mean", *(["seeds with any", "95 %"] if kind == "count" else []), "runs"]


def estimate_cells(row: dict[str, Any], kind: Kind) -> list[str]:
    """Return the cells of the fields of an `Estimate`."""
    known = row["n"] > 0
    cells = interval_cells(row)
    if kind != "share":
        cells.append(f"{row['mean']:.3g}" if known else "-")
    if kind == "count":
        cells += [f"{row['share_any']:.0%}", _any(row)] if known else ["-", ""]
    return [*cells, f"{row['n']:g}" if row["n"] == row["runs"] else f"{row['n']:g} of {row['runs']:g}"]


def interval_cells(row: dict[str, Any]) -> list[str]:
    """Return the figure and its interval."""
    if not row["n"]:
        return ["-", ""]
    has_interval = row["low"] == row["low"]
    ends = f"{row['low']:.3g} to {row['high']:.3g}" if has_interval else f"fewer than {FEWEST_SEEDS} seeds"
    return [f"{row['value']:.3g}", ends]


def _any(row: dict[str, Any]) -> str:
    """Return the interval of the share of seeds with a value other than 0, in percent."""
    if row["share_any"] == 0.0:
        return f"at most {row['any_high']:.0%}"
    return f"{row['any_low']:.0%} to {row['any_high']:.0%}"


def survival_lines(study: Study, rows: pd.DataFrame, curve: Curve) -> tuple[list[str], list[list[str]]]:
    """Return the head of the table, and a line per curve."""
    found = survival.samples(rows, curve.metric, curve.keys)
    measure = (survival_measure(curve.metric) or ("", ""))[1]
    head = [*(label(study, key) for key in curve.keys), "runs", "reached", "median", "95 %"]
    lines = []
    for panel, in_panel in survival.groups(found, curve.panels):
        first: pd.DataFrame | None = None
        for level, shown in survival.groups(in_panel, curve.by):
            names = [text(value) for key, value in ((curve.panels, panel), (curve.by, level)) if key is not None]
            line = [*names, str(len(shown)), str(int(shown["reached"].sum())), *_median(shown, SURVIVAL[measure])]
            if curve.by:
                line.append("" if first is None else _p_value(survival.log_rank(first, shown)))
            first = shown if first is None else first
            lines.append(line)
    return [*head, *(["log-rank p against the first"] if curve.by else [])], lines


def _median(shown: pd.DataFrame, falls: bool) -> list[str]:
    """Return the median and its interval as text, in the order of the measure."""
    middle, *ends = survival.median(survival.curve_of(shown))
    interval = "one seed" if shown["seed"].nunique() < 2 else " to ".join(_value(end, falls) for end in ends)
    return [_value(middle, falls), interval]


def _value(time: float, falls: bool) -> str:
    return "never" if math.isinf(time) else f"{-time if falls else time:.3g}"


def _p_value(p: float) -> str:
    return "-" if math.isnan(p) else "< 0.001" if p < 0.001 else f"{p:.3f}"


EXTREMES = ("lowest", "middle", "highest")


def point_runs(study: Study, rows: pd.DataFrame, curve: Curve, keep_at: str | None) -> Table:
    """Return a table with a line per point: its runs of the lowest, the middle and the highest value.

    Parameters
    ----------
    rows
        Rows of completed runs.
    keep_at
        Folder or fsspec URL of the run folders; the cells then link to them.
    """
    table = Table(f"Runs: {label(study, curve.metric)}")
    for name in (*(label(study, key) for key in curve.keys), *EXTREMES):
        table.add_column(name)
    known = rows[rows[curve.metric].notna()].sort_values([curve.metric, "index"], kind="stable")
    if len(known) and curve.keys:
        levels = groups(rows, curve.keys).loc[known.index]  # in the order of the study, as in the other tables
        for level, members in levels.groupby(curve.keys, sort=True, observed=True):
            of_point = known.loc[members.index].to_dict("records")
            chosen = [of_point[0], of_point[len(of_point) // 2], of_point[-1]]
            table.add_row(*map(text, level), *(_cell(run, curve.metric, keep_at) for run in chosen))
    return table


def _cell(run: dict[str, object], metric: str, keep_at: str | None) -> Span:
    """Return value, place in the study and seed of a run, with a link to its folder if that is kept."""
    shown = f"{run[metric]:.3g} (run {run['index']}, seed {run['seed']})"
    return Span(shown, link=_link(str(run["key"]), keep_at))


def _link(key: str, keep_at: str | None) -> str:
    if keep_at is None:
        return ""
    folder = f"{keep_at.rstrip('/')}/{key}"
    if "://" in keep_at:
        return folder
    path = Path(folder).absolute()
    return path.as_uri() if path.is_dir() else ""  # the row of an earlier start may have been made without --keep


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
    make_folder(folder / PICTURES)
    for one in pictures:
        one.save(folder / PICTURES, list(dict.fromkeys(["png", *formats])))
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
