"""`luxloop thresholds`."""

from pathlib import Path
from typing import Annotated

import typer

from luxloop.scenarios.commands.arguments import (
    AsJson,
    Figures,
    RetryErrors,
    Scheduler,
    StudyName,
    Tracker,
    Workers,
    worker_count,
)
from luxloop.scenarios.commands.extras import require
from luxloop.scenarios.commands.internal_error import print_failed_runs


def thresholds(
    study: StudyName,
    workers: Workers = None,
    scheduler: Scheduler = None,
    out: Annotated[Path | None, typer.Option(help="Folder of the results; thresholds/STUDY if left out.")] = None,
    tracker: Tracker = None,
    retry_errors: RetryErrors = False,
    figures: Figures = None,
    as_json: AsJson = False,
) -> None:
    """Estimate the value of a parameter at which a share of runs keeps a metric, with few runs placed adaptively.

    A second start reuses the runs of an earlier one.
    """
    require("thresholds", "sweeps")
    import json

    from luxloop.scenarios.report import text
    from luxloop.scenarios.report.figure_files import parse_formats
    from luxloop.scenarios.run.device import SHIPPED, absolute
    from luxloop.scenarios.run.progress import hidden
    from luxloop.scenarios.search import threshold_report
    from luxloop.scenarios.search.thresholds import thresholds as estimate
    from luxloop.scenarios.study.study_file import Study, find

    formats = parse_formats(figures)
    path, count = find(study), worker_count(workers, scheduler)
    out, loaded = out or Path("thresholds") / path.stem, Study.load(path)
    notify = (lambda _: None) if as_json else print
    defects: list[str] = []
    with hidden(as_json):
        found = estimate(
            loaded, absolute(tracker or SHIPPED), out, notify, count, scheduler, retry_errors=retry_errors,
            report_defect=defects.append,
        )  # fmt: skip
    threshold_report.write(loaded, found, out, formats)
    if as_json:
        print(json.dumps({**threshold_report.document(loaded, found), "out": str(out)}, allow_nan=False))
    else:
        text.show(threshold_report.report(loaded, found))
        print(f"Estimates, runs and figure are in {out}")
    raise typer.Exit(print_failed_runs(defects) if defects else 0)
