"""`luxloop compare`."""

from pathlib import Path
from typing import Annotated

import typer

from luxloop.scenarios.commands.arguments import AsJson, Quiet, finite
from luxloop.scenarios.exit_codes import ExitCode

BASE_OR_HEAD = "A folder of runs, a single run, or a file that `luxloop baseline` wrote"


def compare(
    base: Annotated[Path, typer.Argument(metavar="BASE", help=f"{BASE_OR_HEAD}: the reference.")],
    head: Annotated[Path, typer.Argument(metavar="HEAD", help="The same: the runs to judge.")],
    loss: Annotated[
        float,
        typer.Option(
            metavar="PERCENT", min=0.0, max=100.0, callback=finite, help="Loss to exclude for an exit code of 0 [%]."
        ),
    ] = 2.0,
    report: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Also write a page (.html), Markdown (.md), or both into a folder."),
    ] = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Compare runs of the same scenarios and seeds.

    Exit code: 0 if HEAD is the same or better, 1 if it is worse or newly fails, 5 if the runs cannot tell.
    """
    import json

    from luxloop.scenarios import interface
    from luxloop.scenarios.compare import comparison_files, comparison_table
    from luxloop.scenarios.compare.comparison_json import document
    from luxloop.scenarios.report import text

    files = comparison_files.files_of(report) if report else []
    comparison = interface.compare(base, head, loss=loss / 100.0)
    comparison_files.write(files, comparison, str(base), str(head))
    if as_json:
        print(json.dumps(document(comparison, str(base), str(head)), allow_nan=False))
    elif not quiet:
        text.show(comparison_table.report(comparison))
        if files:
            print(f"The comparison is in {' and '.join(map(str, files))}")
    raise typer.Exit({"worse": ExitCode.FAILED, "cannot tell": ExitCode.CANNOT_TELL}.get(comparison.outcome, 0))
