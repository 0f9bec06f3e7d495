"""Measure how often intervals of few seeds and vehicles contain the true figure, and write the tables of statistics.md.

luxloop sweep docs/seed_figures/standing.toml --out sweeps/standing     # 600 runs, 10 minutes on one core
luxloop sweep docs/seed_figures/hidden.toml --out sweeps/hidden         # 160 runs, 8 minutes
python docs/interval_coverage.py --collect sweeps                       # the figures of each seed, as CSV files
python docs/interval_coverage.py                                        # the tables, in a minute

The seeds of a sweep are the population, its median or mean the true figure. Studies of 5, 8 and 12 seeds are drawn from
it, and the same functions as in the report of a sweep estimate the figure with its interval. Vehicles are drawn
from the baseline of the catalog in the same way, and estimated with the functions of the page of a run.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

DOCS = Path(__file__).parent
sys.path[:0] = [str(DOCS), str(DOCS.parent)]

import numpy as np  # noqa: E402
from fits import page  # noqa: E402
from intervals.populations import SHOWN, collect, populations  # noqa: E402
from intervals.seed_coverage import Coverage, seed_coverage, survival_coverage  # noqa: E402
from intervals.vehicle_coverage import difference_coverage, vehicle_coverage  # noqa: E402

DRAWS = 2000
PAGE = DOCS / "statistics.md"
SEEDS, VEHICLES = (5, 8, 12), (5, 8, 12, 30)


def main() -> None:
    """Collect the figures of sweeps, or write the tables of the page."""
    if sys.argv[1:2] == ["--collect"]:
        collect(Path(sys.argv[2]))
        return
    for name, table in tables(DRAWS).items():
        page.replace(name, table, PAGE)


def tables(draws: int) -> dict[str, str]:
    """Return the tables of the page by name, from this number of drawn studies or runs for each cell."""
    return {
        "seeds": _table("seeds", SEEDS, _seed_rows(draws)),
        "vehicles": _table("vehicles", VEHICLES, vehicle_coverage(VEHICLES, draws)),
        "differences": _table("vehicles", VEHICLES, difference_coverage(VEHICLES, draws)),
    }


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


if __name__ == "__main__":
    main()
