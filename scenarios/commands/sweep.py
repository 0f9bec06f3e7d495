"""`luxloop sweep` on the command line. What takes long to import is imported where it is needed."""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from scenarios.study.sweep import Sweep


def sweep(
    study: Annotated[str, typer.Argument(metavar="STUDY", help="A shipped study's name, or the path of a .toml file.")],
    workers: Annotated[
        int | None, typer.Option(min=1, help="Processes of this computer, else one for each of its cores.")
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="host:port of a Dask scheduler, whose workers do it instead.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder of the results, else sweeps/STUDY.")] = None,
    tracker: Annotated[
        str | None, typer.Option(metavar="MODULE:NAME", help="Another device under test, see scenarios/device.py.")
    ] = None,
    keep: Annotated[
        str | None, typer.Option(metavar="URL", help="Folder or fsspec URL that gets every run's folder, too.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print what became of it as JSON, and nothing else.")] = False,
) -> None:
    """Run a study, all combinations with all seeds; started again, it does what is not done yet.

    Exit with 1 if a run ended with an error. That expectations of its scenario fail is what a study is to find out.
    """
    import json

    from scenarios.device import SHIPPED
    from scenarios.errors import StudyError
    from scenarios.study.study import Study, find
    from scenarios.study.sweep import sweep as carry_out

    if workers and scheduler:
        raise StudyError("--workers and --scheduler are both given; the scheduler has workers of its own, give one")
    path = find(study)
    out = out or Path("sweeps") / path.stem
    done = carry_out(Study.load(path), tracker or SHIPPED, out, workers or _cores(), scheduler, keep)
    if as_json:
        print(json.dumps(document(done, out), allow_nan=False))
    else:
        print(_told(done, out))
    raise typer.Exit(1 if (done.rows["status"] == "error").any() else 0)


def document(done: "Sweep", out: Path) -> dict[str, Any]:
    """Return what `--json` prints."""
    from scenarios.study.rows import RUNS

    return {
        "study": done.study.path.stem,
        "runs": done.count,
        "status": {str(name): int(count) for name, count in done.rows["status"].value_counts().sort_index().items()},
        "errors": sorted(set(done.rows.loc[done.rows["status"] == "error", "error"])),
        "out": str(out),
        "rows": str(out / RUNS),
    }


def _told(done: "Sweep", out: Path) -> str:
    """Return what a person reads."""
    from scenarios.study.rows import RUNS

    told = document(done, out)
    counts = ", ".join(f"{count} {name}" for name, count in told["status"].items())
    lines = [f"{done.count} runs: {counts}.", *(f"error: {error}" for error in told["errors"][:5])]
    return "\n".join([*lines, f"A row per run is in {out / RUNS}"])


def _cores() -> int:
    """Return how many cores this process may use: fewer than there are in a container."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
