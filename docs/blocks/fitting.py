"""Results of the fits: tables over the runs of the catalog, and the worst fits of a run and of real cars."""

from functools import cache
from pathlib import Path

from blocks import commands
from fits import coverage, pictures, real_cases
from fits.case import Case
from fits.league import compare
from fits.league_tables import summary, table
from fits.observations import observations
from fits.simulated_cases import worst_cases

PICTURES = Path(__file__).parents[1] / "pictures"
DRAWN = 8
"""Number of real cars in the picture, those with the largest errors."""


@cache
def catalog_tables() -> dict[str, str]:
    """Return the tables of the selection beside its candidates over all runs, and of the coverage, by block."""
    observed = observations([commands.catalog()])
    together, apart = compare(observed)
    return {
        "candidates": table(together, by_scenario=False),
        "losses": summary(apart),
        "coverage": coverage.table(observed),
    }


def catalog_table(name: str) -> str:
    """Return one of the tables."""
    return catalog_tables()[name]


def simulated_picture(_name: str) -> None:
    """Draw the worst fits of the crossing."""
    run = commands.run("sumo-crossing", "luxloop run sumo-crossing --record-scans")
    pictures.draw(worst_cases(run), PICTURES / "fitting_simulated.png")


@cache
def real_cars() -> list[Case]:
    """Return the fits to the labelled cars."""
    return real_cases.labelled(commands.real("ouster"))


def real_table(_name: str) -> str:
    """Return the table of the labelled cars."""
    return real_cases.table(real_cars())


def real_picture(_name: str) -> None:
    """Draw the labelled cars with the largest errors."""
    pictures.draw(sorted(real_cars(), key=lambda case: -case.worst)[:DRAWN], PICTURES / "fitting_real.png")
