"""`luxloop baseline`."""

from pathlib import Path
from typing import Annotated

import typer


def baseline(
    runs: Annotated[Path, typer.Argument(metavar="RUNS", help="The folder of runs that become the baseline.")],
    out: Annotated[Path, typer.Option(help="The file to write and commit; it replaces an earlier baseline.")],
) -> None:
    """Write a baseline file for `luxloop compare`. No other command changes one."""
    from luxloop.scenarios.compare import baseline_file as file
    from luxloop.scenarios.compare import sides
    from luxloop.scenarios.compare.run_pairs import listed

    side = sides.read_runs(runs)
    before = {run.key: run for run in file.read(out)} if out.exists() else {}
    file.write(out, list(side.runs.values()))
    changed = [key for key in side.runs if key in before and side.runs[key].trace_hash != before[key].trace_hash]
    print(f"{out}: {len(side.runs)} runs, {out.stat().st_size / 1000:.0f} kB")
    for what, keys in (
        ("new", [key for key in side.runs if key not in before]),
        ("changed", changed),
        ("dropped", [key for key in before if key not in side.runs]),
        ("ended early, and are not compared", [key for key, run in side.runs.items() if run.ended_early]),
    ):
        if keys:
            print(f"{len(keys)} {what}: {listed(keys)}")
