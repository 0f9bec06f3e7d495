"""The paper's four tables, beside those of its own steps and of the default tracker, and the verdict on its steps."""

import shutil

from blocks import commands
from blocks.markdown import markdown

from luxloop.scenarios.document.document import plain
from luxloop.scenarios.interface import load_result
from luxloop.scenarios.report.paper_comparison import TABLES, Sources
from luxloop.scenarios.report.paper_comparison import verdict as verdict_on

COLUMNS = ("the paper's steps", "default")


def sources() -> Sources:
    """Return the metrics of both drives, by their columns."""
    folders = (commands.RUNS / "paper-campus-seed1-paper", commands.RUNS / "paper-campus-seed1")
    if not commands.of_baseline("paper-campus"):
        for folder in folders:
            shutil.rmtree(folder, ignore_errors=True)  # `luxloop paper` uses runs again
    commands.output("luxloop paper")
    commands.run("paper-campus")
    return {name: load_result(run).metrics for name, run in zip(COLUMNS, folders, strict=True)}


def verdict(_name: str) -> str:
    """Return the sentence on the paper's steps."""
    return verdict_on(COLUMNS[0], sources()[COLUMNS[0]])


def table(name: str) -> str:
    """Return `table 1` to `table 4`."""
    return as_markdown(int(name.removeprefix("table ")), sources())


def as_markdown(number: int, given: Sources) -> str:
    """Return one of the paper's tables."""
    made = TABLES[number - 1](given)
    rows = [[plain(cell).replace("|e|", "abs. e") for cell in row.cells] for row in made.rows]
    return markdown([column.head for column in made.columns], rows)
