"""`luxloop compare`."""

from pathlib import Path
from typing import Annotated

import typer

from scenarios.commands.arguments import AsJson

BASE_OR_HEAD = "A folder of runs, a single run, or a file that `luxloop baseline` wrote"


def compare(
    base: Annotated[Path, typer.Argument(metavar="BASE", help=f"{BASE_OR_HEAD}: the reference.")],
    head: Annotated[Path, typer.Argument(metavar="HEAD", help="The same: the runs to judge.")],
    as_json: AsJson = False,
) -> None:
    """Compare runs of the same scenarios and seeds, and exit with 1 if HEAD is worse or newly fails."""
    import json

    from scenarios.compare import comparison as verdict
    from scenarios.compare import comparison_table, run_pairs, sides
    from scenarios.compare.comparison_json import document
    from scenarios.report import text

    comparison = verdict.compare(run_pairs.pair(sides.read(base), sides.read(head)))
    if as_json:
        print(json.dumps(document(comparison, str(base), str(head)), allow_nan=False))
    else:
        text.show(comparison_table.report(comparison))
    raise typer.Exit(1 if comparison.failed or comparison.verdict == "worse" else 0)
