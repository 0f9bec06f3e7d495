"""Coverage of the true figure by intervals of few seeds and vehicles.

    luxloop sweep docs/seed_figures/standing.toml --out sweeps/standing     # 600 runs, 10 minutes on one core
    luxloop sweep docs/seed_figures/hidden.toml --out sweeps/hidden         # 160 runs, 8 minutes

`collect` of intervals/populations.py writes the figures of each seed as CSV files. The seeds of a sweep are the
population, its median or mean the true figure. Studies of 5, 8 and 12 seeds are drawn from it, and the same functions
as in the report of a sweep estimate the figure with its interval. Vehicles are drawn from the baseline of the catalog
in the same way, and estimated with the functions of the page of a run.
"""

from collections.abc import Iterator

import numpy as np
from intervals.populations import SHOWN, populations
from intervals.seed_coverage import Coverage, seed_coverage, survival_coverage
from intervals.vehicle_coverage import difference_coverage, vehicle_coverage

DRAWS = 2000
"""Drawn studies or runs for each cell of the page."""
SEEDS, VEHICLES = (5, 8, 12), (5, 8, 12, 30)


def table(name: str, draws: int = DRAWS) -> str:
    """Return the table `seeds`, `vehicles` or `differences`."""
    if name == "seeds":
        return _table("seeds", SEEDS, _seed_rows(draws))
    rows = vehicle_coverage if name == "vehicles" else difference_coverage
    return _table("vehicles", VEHICLES, rows(VEHICLES, draws))


def _seed_rows(draws: int) -> Iterator[tuple[str, list[Coverage]]]:
    for one in populations(SHOWN):
        for kind in one.kinds:
            yield (
                f"{one.name}, {kind}",
                [seed_coverage(one.rows, kind, seeds, draws, np.random.default_rng(seeds)) for seeds in SEEDS],
            )
    for runs, at_s in ((1, 0.2), (1, 0.7), (2, 0.7), (2, 1.6)):
        yield (
            f"survival curve at {at_s} s, {runs} run{'s' * (runs > 1)} of a seed (simulated)",
            [survival_coverage(seeds, runs, at_s, draws, np.random.default_rng(seeds)) for seeds in SEEDS],
        )


def _table(samples: str, numbers: tuple[int, ...], rows: "Iterator[tuple[str, list[Coverage]]]") -> str:
    """Return a Markdown table with a row per figure: the truth, then coverage and median width by sample size."""
    lines = [
        f"| figure | truth | {' | '.join(f'{number} {samples}: covered, width' for number in numbers)} |",
        "|---|---|" + "---|" * len(numbers),
    ]
    for name, found in rows:
        cells = [f"{100 * one.share:.1f} %, {one.width:.2g}" for one in found]
        lines.append(f"| {name} | {found[0].truth:.3g} | {' | '.join(cells)} |")
    return "\n".join(lines)
