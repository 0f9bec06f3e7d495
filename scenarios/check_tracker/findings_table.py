"""What was found of a tracker, for people."""

from rich import box
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from scenarios.check_tracker.checks import CHECKS, Findings


def table(findings: Findings, name: str) -> RenderableType:
    """A line for each check, and for each one that failed what is wrong, where, and what to do."""
    rows = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False)
    rows.add_column("check", no_wrap=True)
    rows.add_column("")
    rows.add_column("", overflow="fold")
    for check, remedy in CHECKS.items():
        faults = findings.of(check)
        if faults:
            first, others = faults[0], f" (and {len(faults) - 1} more times)" if len(faults) > 1 else ""
            told = f"{first.what}; in {first.where}{others}; {remedy}"
            rows.add_row(check, Text("FAILED", "bold red"), Text(told))
        elif check in findings.done:
            rows.add_row(check, Text("passed", "green"), "")
        else:
            rows.add_row(check, Text("not done", "yellow"), Text("there was nothing to check", "dim"))
    failed = sum(bool(findings.of(check)) for check in CHECKS)
    verdict = Text("PASSED", "bold green") if findings.passed else Text("FAILED", "bold red")
    told = f": {name} fails {failed} of {len(CHECKS)} checks" if failed else f": {name} keeps the contract"
    return Group(rows, verdict.append(told, "not bold default"))
