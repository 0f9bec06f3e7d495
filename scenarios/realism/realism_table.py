"""Comparison with real vehicles as text and as JSON."""

from typing import Any

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from luxloop.scenarios.realism.compared_figures import Figure
from luxloop.scenarios.realism.compared_row import ComparedRow
from luxloop.scenarios.realism.nearest_vehicles import NEAREST
from luxloop.scenarios.realism.realism_comparison import FAR, Comparison
from luxloop.scenarios.realism.weighted_average import Summary
from luxloop.scenarios.report.cells import NONE, table_of

STYLES = {"agrees": "green", "differs": "red", NONE: "dim"}


def report(comparison: Comparison) -> Group:
    """Return the printed comparison."""
    sections: list[RenderableType] = [_table(comparison.rows), _notes(comparison)]
    return Group(*(Padding(section, (0, 0, 1, 0), expand=False) for section in sections))


def document(comparison: Comparison) -> dict[str, Any]:
    """Return the comparison as JSON, in the units of the tables."""
    return {
        "real_vehicles": len(comparison.real),
        "simulated_observations": comparison.observations,
        "matched_observations": len(comparison.vehicles),
        "far_matches": comparison.far,
        "differs": [row.figure.name for row in comparison.rows if row.verdict == "differs"],
        "figures": {row.figure.name: _entry(row) for row in comparison.rows},
    }


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
            Text(f"{row.figure.label}{_unit(row.figure)}"),
            _value(real, row.figure),
            _range(real and real.quartiles, row.figure),
            str(real.n if real else 0),
            _value(simulated, row.figure),
            _range(simulated and simulated.interval, row.figure),
            str(simulated.n if simulated else 0),
            Text(row.verdict, style=STYLES[row.verdict]),
        )
    return table


def _notes(comparison: Comparison) -> Text:
    judged = [row for row in comparison.rows if row.verdict != NONE]
    agreeing = sum(row.verdict == "agrees" for row in judged)
    actors = comparison.matched.groupby(["data_set", "actor_id"]).ngroups
    return Text(
        f"{agreeing} of {len(judged)} figures agree: within 25 % of the real one or inside its quartiles; "
        "heading errors within 50 %.\n"
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
