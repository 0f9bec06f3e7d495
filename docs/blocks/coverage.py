"""Coverage of the true figure by intervals of few seeds and vehicles.

    luxloop sweep docs/seed_figures/standing.toml --out sweeps/standing     # 600 runs, 10 minutes on one core
    luxloop sweep docs/seed_figures/hidden.toml --out sweeps/hidden         # 160 runs, 8 minutes

`collect` of intervals/seed_coverage.py writes the figures of each seed as CSV files. The seeds of a sweep are the
population, its median or mean the true figure. Studies of 5, 8 and 12 seeds are drawn from it, and the same functions
as in the report of a sweep estimate the figure with its interval. Vehicles are drawn from the baseline of the catalog
in the same way, and estimated with the functions of the page of a run.
"""

from blocks.markdown import markdown
from intervals.seed_coverage import populations, seed_coverage
from intervals.vehicle_coverage import vehicle_coverage

DRAWS = 2000
"""Drawn studies or runs for each cell of the page."""
SEEDS, VEHICLES = (5, 8, 12), (5, 8, 12, 30)


def table(name: str, draws: int = DRAWS) -> str:
    """Return the table `seeds`, `vehicles` or `differences`: the truth, coverage and median width by sample size."""
    if name == "seeds":
        sizes = [f"{number} seeds" for number in SEEDS]
        rows = [(f"{p.name}, {p.kind}", [seed_coverage(p, seeds, draws) for seeds in SEEDS]) for p in populations()]
    else:
        sizes = [f"{number} vehicles" for number in VEHICLES]
        rows = list(vehicle_coverage(name, VEHICLES, draws))
    head = ("figure", "truth", *(f"{size}: covered, width" for size in sizes))
    cells = (
        (figure, f"{found[0].truth:.3g}", *(f"{100 * one.share:.1f} %, {one.width:.2g}" for one in found))
        for figure, found in rows
    )
    return markdown(head, cells)
