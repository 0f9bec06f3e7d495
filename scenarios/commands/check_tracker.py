"""`luxloop check-tracker`."""

from typing import Annotated

import typer


def check_tracker(
    tracker: Annotated[str, typer.Argument(metavar="MODULE:NAME", help="A tracker, as for `luxloop run --tracker`.")],
) -> None:
    """Check that a tracker keeps the interface contract, with real and degenerate scans."""
    from luxloop.scenarios.check_tracker.check_drives import drives
    from luxloop.scenarios.check_tracker.findings_table import table
    from luxloop.scenarios.check_tracker.sequence_checks import examine
    from luxloop.scenarios.report import text
    from luxloop.scenarios.run import device

    findings = examine(device.load(tracker), drives())
    text.show(table(findings, tracker))
    raise typer.Exit(0 if findings.passed else 1)
