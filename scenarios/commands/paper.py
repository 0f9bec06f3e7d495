"""`luxloop paper`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from luxloop.scenarios.result import Result

SCENARIO = "paper-campus"
"""The surrogate of the paper's drive."""


def paper(
    run: Annotated[
        Path | None,
        typer.Argument(metavar="[RUN]", help=f"A folder of luxloop run; if left out, of {SCENARIO}, run if missing."),
    ] = None,
    table: Annotated[int | None, typer.Option(min=1, max=4, help="Only this table of the paper.")] = None,
    latex: Annotated[bool, typer.Option("--latex", help="Print LaTeX, for the package booktabs.")] = False,
) -> None:
    """Print the paper's tables I to IV for a run, with the paper's own figures beside them."""
    from rich.console import Group
    from rich.text import Text

    from luxloop.scenarios import interface
    from luxloop.scenarios.report import latex as latex_tables
    from luxloop.scenarios.report import paper_tables, text
    from luxloop.scenarios.report.html.page_tables import page_table

    result = interface.load_result(run) if run else _own_run()
    makers = [paper_tables.dataset, paper_tables.heading_error, paper_tables.heading_distribution]
    makers = [*makers, paper_tables.position_error]
    shown = [make(result) for make in (makers if table is None else makers[table - 1 : table])]
    if latex:
        print(latex_tables.document(map(page_table, shown), f"{result.scenario}, seed {result.seed}"), end="")
    else:
        text.show(Group(text.header(result), *(part for one in shown for part in (Text(), one))))


def _own_run() -> "Result":
    """Return the run of the paper's scenario in its default folder, and run it first if there is none."""
    from luxloop.scenarios import interface
    from luxloop.scenarios.execute import default_folder
    from luxloop.scenarios.run import run_folder

    scenario = interface.load_scenario(SCENARIO)
    out = default_folder(scenario)
    if (out / run_folder.RESULT).is_file():
        return interface.load_result(out)
    return interface.run(scenario, out=out, ahead=False, progress=True)
