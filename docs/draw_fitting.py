"""Write the results of fitting.md: its tables, and the pictures of the worst fits in docs/pictures.

    luxloop run sumo-crossing --record-scans
    python docs/draw_fitting.py --catalog runs/catalog --real REAL_DATA_DIR runs/sumo-crossing-seed1

`--catalog` is a folder of finished runs, for instance of all scenarios. REAL_DATA_DIR has the folder `ouster` with the
recordings; docs/ouster-twin.md says where they come from. The run with recorded scans is drawn. Parts without an input
stay as they are.
"""

import argparse
import sys
from pathlib import Path

from candidates import compare, observations
from fits import coverage, pictures, real_cases
from fits.league_tables import summary, table
from fits.page import PICTURES, replace
from fits.simulated_cases import worst_cases

from luxloop.scenarios.errors import OutputError

SIMULATED, REAL = PICTURES / "fitting_simulated.png", PICTURES / "fitting_real.png"
DRAWN = 8
"""Number of real cars in the picture, those with the largest errors."""


def main() -> None:
    """Write the parts whose inputs are given."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path, nargs="?", help="run folder with recorded scans")
    parser.add_argument("--catalog", type=Path, help="folder of finished runs")
    parser.add_argument("--real", type=Path, help="folder of the real recordings")
    given = parser.parse_args()
    try:
        if given.catalog:
            write_catalog(given.catalog)
        if given.run:
            pictures.draw(worst_cases(given.run), SIMULATED)
    except OutputError as error:
        sys.exit(str(error))
    if given.real:
        write_real(given.real / "ouster")


def write_catalog(folder: Path) -> None:
    """Write the tables of the candidates and of the coverage."""
    observed = observations([folder])
    together, apart = compare(observed)
    losses = [one for one in apart if one.losses]
    replace("candidates", table(together, by_scenario=False))
    replace("scenarios", table([one for one in apart if one.group == "all"], by_scenario=True))
    replace("losses", f"{summary(apart)}\n\n{table(losses, by_scenario=True)}")
    replace("coverage", coverage.table(observed))


def write_real(folder: Path) -> None:
    """Write the table of the real cars and draw those with the largest errors."""
    if not folder.is_dir():
        sys.exit(f"{folder}: no such folder; give the folder that contains `ouster`")
    cases = real_cases.labelled(folder)
    replace("real cars", real_cases.table(cases))
    pictures.draw(sorted(cases, key=lambda case: -case.worst)[:DRAWN], REAL)


if __name__ == "__main__":
    main()
