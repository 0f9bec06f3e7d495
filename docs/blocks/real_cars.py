"""Labelled cars of public Ouster recordings beside their simulated twins: tables and picture."""

from functools import cache
from pathlib import Path

import matplotlib
import numpy as np
from blocks import commands, realism
from matplotlib.figure import Figure
from twin import tables
from twin.pairs import Pair, pairs

from luxloop.scenarios.document.figure import STYLE
from luxloop.scenarios.document.palette import PAGE
from luxloop.scenarios.realism import realism_figures

PICTURE = Path(__file__).parents[1] / "pictures" / "realism_real_cars.png"
TWINS = 3
"""Twins of each car in the comparison of shapes."""
SHOWN = 4
"""Cars in the picture."""


@cache
def found() -> list[Pair]:
    """Return the labelled cars with their twins."""
    return list(pairs(commands.real("ouster")))


def counts(_name: str) -> str:
    """Return the errors of the number of points, and the ratio by height."""
    return tables.summary(found())


def headings(_name: str) -> str:
    """Return the heading errors by method."""
    return tables.heading_table(found())


def table(_name: str) -> str:
    """Return the comparison of shapes in four layers."""
    each = list(enumerate(found()))
    real = tables.enough([pair.real.four_layers().vehicle(number) for number, pair in each])
    twins = tables.enough([one.four_layers().vehicle(number) for number, pair in each for one in pair.twins[:TWINS]])
    return realism.table(realism.against(real, twins).rows)


def picture(_name: str) -> None:
    """Draw real cars of which an end and a side are visible above their twins, evenly spaced over their ranges."""
    whole = [pair for pair in found() if pair.car.end_seen and pair.car.side_seen]
    whole.sort(key=lambda pair: pair.car.range_m)
    shown = [whole[round(n)] for n in np.linspace(0, len(whole) - 1, SHOWN)]
    with matplotlib.rc_context(STYLE):
        canvas = Figure(figsize=(10.4, 4.4), layout="constrained", facecolor=PAGE)
        grid = canvas.subplots(2, SHOWN)
        for (above, below), pair in zip(grid.T, shown, strict=True):
            points = realism_figures.plan(above, pair.real.vehicle(0))
            realism_figures.plan(below, pair.twins[0].vehicle(0))
        grid[0, 0].set_ylabel("real")
        grid[1, 0].set_ylabel("simulated")
        canvas.colorbar(points, ax=list(grid.ravel()), label="height [m]", shrink=0.6)
        canvas.savefig(PICTURE, dpi=110, metadata={"Software": None})
