"""Counts of points and headings of fits on labelled cars of public Ouster recordings, beside their simulated twins."""

from functools import cache

from blocks import commands
from twin import tables
from twin.comparison import Compared, compare
from twin.simulated import SENSOR


@cache
def compared() -> list[Compared]:
    """Return the labelled cars with the figures of their twins."""
    return list(compare(commands.real("ouster"), SENSOR))


def counts(_name: str) -> str:
    """Return the errors of the number of points, and the ratio by height."""
    return tables.summary(compared())


def headings(_name: str) -> str:
    """Return the heading errors by method."""
    return tables.heading_table(compared())
