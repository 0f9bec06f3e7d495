"""Compare the tracker's selection with each of its candidates in finished runs: by scenario, view, range and points.

    python docs/candidates.py runs/catalog
    python docs/candidates.py runs/catalog --every

The first prints the groups over all runs, each scenario as a whole, and the losses. `--every` prints every group of
every scenario. Folders are run folders or contain them. Errors are mean absolute heading errors modulo 90 degrees;
intervals resample vehicles.
"""

import argparse
import sys
from pathlib import Path

import pandas as pd
from fits import coverage
from fits.league import Standing, standings
from fits.league_tables import summary, table
from fits.observations import of_runs

from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.run import run_folder


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="+", help="folder of runs")
    parser.add_argument("--every", action="store_true", help="print every group of every scenario")
    given = parser.parse_args()
    try:
        observed = observations(given.folder)
    except OutputError as error:
        sys.exit(str(error))
    together, apart = compare(observed)
    print(f"All runs\n\n{table(together, by_scenario=False)}\n")
    print(f"By scenario\n\n{table([one for one in apart if one.group == 'all'], by_scenario=True)}\n")
    shown = apart if given.every else [one for one in apart if one.losses]
    print(f"{'Every group' if given.every else 'Losses'}\n\n{table(shown, by_scenario=True)}\n")
    print(f"{summary(apart)}\n\nCoverage of the heading's intervals\n\n{coverage.table(observed)}")


def observations(folders: list[Path]) -> pd.DataFrame:
    """Return the observations of all runs in folders.

    Raises
    ------
    OutputError
        No folder contains a run, or a run is damaged or has no fits.
    """
    runs = [run for folder in folders for run in run_folder.found_in(folder)]
    if not runs:
        raise OutputError(f"{', '.join(map(str, folders))}: no runs in it; give a folder that contains run folders")
    observed = of_runs(runs)
    if observed.empty:
        raise OutputError(f"{', '.join(map(str, folders))}: no fits in its runs; the tracker gave no trace")
    return observed


def compare(observed: pd.DataFrame) -> tuple[list[Standing], list[Standing]]:
    """Return the groups over all runs, and those of each scenario."""
    apart = [one for name, rows in observed.groupby("scenario") for one in standings(rows, str(name))]
    return standings(observed, "all"), apart


if __name__ == "__main__":
    main()
