"""Write the paper's four tables, of the default tracker and of the paper's own steps, into docs/paper.md.

    for seed in 1 11 12 13; do
        luxloop run paper-campus --seed $seed --no-recording
        luxloop run docs/examples/paper-variant.toml --seed $seed --no-recording
    done
    python docs/paper_variants.py runs

Arguments are run folders or contain them; other scenarios and seeds in them are left out. Each run takes one to three
minutes. The tables are printed and written between `<!-- table 1 -->` ... `<!-- table 4 -->` and `<!-- end -->`. Seed 1
is graded alone, the others together; intervals are over whole vehicles.
"""

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

from fits import page
from variants import tables
from variants.pooled import Pooled, pooled

from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.result import Result
from luxloop.scenarios.run import run_folder

PAGE = Path(__file__).parent / "paper.md"
TRACKERS = {"default": "paper-campus", "the paper's steps": "paper-variant"}
"""Names of the trackers in the tables, and the scenarios that run them."""
COMMANDS = {"paper-campus": "paper-campus", "paper-variant": "docs/examples/paper-variant.toml"}
SEEDS = {"seed 1": (1,), "seeds 11 to 13": (11, 12, 13)}
"""Seeds that are graded together, by their names in the tables."""
TABLES: dict[str, Callable[[tables.Trackers], str]] = {
    "table 1": tables.table_1,
    "table 2": tables.table_2,
    "table 3": tables.table_3,
    "table 4": tables.table_4,
}
"""Tables by their marks in the page."""


def main() -> None:
    """Print the tables and write them into the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="+", help="folder of runs")
    parser.add_argument("--page", type=Path, default=PAGE, help="page with the marks of the tables")
    given = parser.parse_args()
    try:
        trackers = graded(given.folder)
    except OutputError as error:
        sys.exit(str(error))
    for name, table in TABLES.items():
        text = table(trackers)
        print(f"{name}\n\n{text}\n")
        page.replace(name, text, given.page)


def graded(folders: list[Path]) -> dict[str, dict[str, Pooled]]:
    """Return the runs of each tracker and its seeds.

    Raises
    ------
    OutputError
        A run is missing, double or damaged, or the runs of a seed differ in their frames.
    """
    wanted = {(scenario, seed) for scenario in TRACKERS.values() for seeds in SEEDS.values() for seed in seeds}
    runs: dict[tuple[str, int], Result] = {}
    for path in (path for folder in folders for path in run_folder.found_in(folder)):
        result = run_folder.read(path)
        key = (result.scenario, result.seed)
        if key in runs:
            raise OutputError(f"{path}: a second run of {key[0]} with seed {key[1]}; give the folder of one of them")
        if key in wanted:
            runs[key] = result
    for scenario, seed in sorted(wanted - set(runs)):
        raise OutputError(_missing(folders, scenario, seed))
    _same_drives(runs)
    return {
        tracker: {name: pooled([runs[scenario, seed] for seed in seeds]) for name, seeds in SEEDS.items()}
        for tracker, scenario in TRACKERS.items()
    }


def _same_drives(runs: dict[tuple[str, int], Result]) -> None:
    """Refuse runs of one seed with different numbers of frames: one has a shorter duration, or its simulator failed.

    A run may end a few frames early because the ego arrives, then with either tracker.
    """
    (first, other) = TRACKERS.values()
    for seed in (seed for seeds in SEEDS.values() for seed in seeds):
        frames = runs[first, seed].frames, runs[other, seed].frames
        if frames[0] != frames[1]:
            different = f"{frames[0]} and {frames[1]} frames"
            raise OutputError(f"runs of {first} and {other} with seed {seed} have {different}; run both again")


def _missing(folders: list[Path], scenario: str, seed: int) -> str:
    command = f"luxloop run {COMMANDS[scenario]} --seed {seed}"
    return f"{', '.join(map(str, folders))}: no run of {scenario} with seed {seed}; make it by: {command}"


if __name__ == "__main__":
    main()
