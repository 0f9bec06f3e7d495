"""`luxloop compare` and `luxloop baseline`."""

from pathlib import Path
from typing import Annotated

import typer

from scenarios.commands.arguments import AsJson

BASE_OR_HEAD = "A folder of runs, a single run, or a file that `luxloop baseline` wrote"


def compare(
    base: Annotated[Path, typer.Argument(metavar="BASE", help=f"{BASE_OR_HEAD}: what was before.")],
    head: Annotated[Path, typer.Argument(metavar="HEAD", help="Likewise: what is now.")],
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


def baseline(
    runs: Annotated[Path, typer.Argument(metavar="RUNS", help="The folder of runs that shall be the baseline.")],
    out: Annotated[Path, typer.Option(help="The file, to be committed; an earlier baseline there is replaced.")],
) -> None:
    """Write a baseline file for `luxloop compare`: the only way in which one ever changes."""
    from scenarios.compare import baseline_file as file
    from scenarios.compare import sides
    from scenarios.compare.run_pairs import listed

    side = sides.read_runs(runs)
    before = {run.key: run for run in file.read(out)} if out.exists() else {}
    file.write(out, list(side.runs.values()))
    changed = [key for key in side.runs if key in before and side.runs[key].trace_hash != before[key].trace_hash]
    print(f"{out}: {len(side.runs)} runs, {out.stat().st_size / 1000:.0f} kB")
    for what, keys in (
        ("new", [key for key in side.runs if key not in before]),
        ("changed", changed),
        ("dropped", [key for key in before if key not in side.runs]),
        ("ended early, and will not be compared", [key for key, run in side.runs.items() if run.ended_early]),
    ):
        if keys:
            print(f"{len(keys)} {what}: {listed(keys)}")
