"""Comparison with real vehicles as a document, and the folder of its files."""

import json
from pathlib import Path
from typing import Any

from luxloop.scenarios.document.document import Answer, Document, Paragraph, Section, Span, Style, Table, json_data
from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files import atomic_file, atomic_folder
from luxloop.scenarios.realism import realism_figures
from luxloop.scenarios.realism.realism_comparison import FAR, NEAREST, ComparedRow, Comparison, Figure, Summary
from luxloop.scenarios.report import text
from luxloop.scenarios.report.cells import NONE, table_of

STYLES: dict[str, Style] = {"agrees": "good", "differs": "bad", NONE: "dim"}


def document(comparison: Comparison) -> Document:
    """Return the comparison; its figures for programs are in the units of the tables."""
    judged = [row for row in comparison.rows if row.verdict != NONE]
    agreeing = sum(row.verdict == "agrees" for row in judged)
    answer = Answer(f"{agreeing} of {len(judged)} figures of the simulated vehicles agree with the real ones")
    figures = Section("figures", "Figures", [_table(comparison.rows), Paragraph(_notes(comparison))])
    data = {
        "real_vehicles": len(comparison.real),
        "simulated_observations": comparison.observations,
        "matched_observations": len(comparison.vehicles),
        "far_matches": comparison.far,
        "differs": [row.figure.name for row in judged if row.verdict == "differs"],
        "figures": {row.figure.name: _entry(row) for row in comparison.rows},
    }
    return Document("Simulated beside real vehicles", answer, [], [figures], data)


def _entry(row: ComparedRow) -> dict[str, Any]:
    sides = {"real": row.real, "simulated": row.simulated}
    return {
        "average": row.figure.average,
        **{side: summary and summary._asdict() for side, summary in sides.items()},
        "verdict": row.verdict,
    }


def _table(rows: list[ComparedRow]) -> Table:
    table = table_of("Simulated beside real", "figure", "real", "quartiles", "n", "simulated", "95 %", "n")
    table.add_column("verdict", no_wrap=True)
    for row in rows:
        real, simulated = row.real, row.simulated
        table.add_row(
            f"{row.figure.label}{_unit(row.figure)}",
            _value(real, row.figure),
            _range(real and real.quartiles, row.figure),
            str(real.n if real else 0),
            _value(simulated, row.figure),
            _range(simulated and simulated.interval, row.figure),
            str(simulated.n if simulated else 0),
            Span(row.verdict, STYLES[row.verdict]),
        )
    return table


def _notes(comparison: Comparison) -> str:
    actors = comparison.matched.groupby(["data_set", "actor_id"]).ngroups
    return (
        "A figure agrees within 25 % of the real one or inside its quartiles; heading errors within 50 %.\n"
        "Ends are fronts and rears. Medians; shares inside and outside and heading errors are means.\n"
        "Intervals are over whole vehicles.\n"
        f"{len(comparison.real)} real vehicles, each with its {NEAREST} nearest of {comparison.observations} simulated "
        f"observations: {len(comparison.vehicles)} of {actors} vehicles.\n"
        "Bands of height: all simulated vehicles.\n"
        f"{comparison.far} real vehicles have no simulated one within {FAR:g} scales of range and aspect."
    )


def _unit(figure: Figure) -> str:
    return "" if figure.unit == "1" else f" [{figure.unit}]"


def _value(summary: Summary | None, figure: Figure) -> str:
    return NONE if summary is None else f"{figure.scale * summary.value:.{figure.digits}f}"


def _range(ends: tuple[float, float] | None, figure: Figure) -> str:
    return "" if ends is None else ", ".join(f"{figure.scale * end:.1f}" for end in ends)


DOCUMENT, TABLE, MATCHED = "realism.json", "realism.txt", "matched.csv"
FIGURE_FORMAT = "%.6g"
OPTION = "--out"


def write(comparison: Comparison, out: Path) -> None:
    """Write the folder atomically; an earlier one of the same kind is replaced.

    Raises
    ------
    OutputError
        The folder cannot be written, or holds other files.
    """
    with atomic_folder.create(out, OPTION, refuse_other_files) as folder, atomic_file.writing(out, OPTION):
        shown = document(comparison)
        figures = json.dumps(json_data(shown), indent=2, allow_nan=False)
        (folder / DOCUMENT).write_text(figures + "\n", encoding="utf-8")
        (folder / TABLE).write_text(text.as_text(shown), encoding="utf-8")
        comparison.matched.to_csv(folder / MATCHED, index=False, float_format=FIGURE_FORMAT)
        realism_figures.save(comparison, folder)


def refuse_other_files(out: Path) -> None:
    """Check that `out` is new, or an earlier comparison.

    Raises
    ------
    OutputError
        It holds other files.
    """
    if out.exists() and not (out / DOCUMENT).is_file():
        raise OutputError(f"{out}: already exists and holds no earlier comparison; choose another folder with {OPTION}")
