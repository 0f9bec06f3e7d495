"""Findings of a tracker as a table for the terminal."""

from rich import box
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from luxloop.scenarios.check_tracker.checks import CHECKS, Findings


def table(findings: Findings, name: str) -> RenderableType:
    """Return a table with one row per check; failed checks show the fault, its location and the remedy."""
    rows = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False)
    rows.add_column("check", no_wrap=True)
    rows.add_column("")
    rows.add_column("", overflow="fold")
    for check, remedy in CHECKS.items():
        faults = findings.of(check)
        if faults:
            first, others = faults[0], f" (and {len(faults) - 1} more times)" if len(faults) > 1 else ""
            message = f"{first.what}; in {first.where}{others}; {remedy}"
            rows.add_row(check, Text("FAILED", "bold red"), Text(message))
        elif check in findings.done:
            rows.add_row(check, Text("passed", "green"), "")
        else:
            rows.add_row(check, Text("not done", "yellow"), Text("no data to check", "dim"))
    failed = sum(bool(findings.of(check)) for check in CHECKS)
    verdict = Text("PASSED", "bold green") if findings.passed else Text("FAILED", "bold red")
    summary = f": {name} fails {failed} of {len(CHECKS)} checks" if failed else f": {name} meets the contract"
    return Group(rows, verdict.append(summary, "not bold default"))
