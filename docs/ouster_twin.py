"""Compare labelled cars of public Ouster recordings with simulated twins: counts of points, and headings of fits.

    python docs/ouster_twin.py REAL_DATA_DIR
    python docs/ouster_twin.py REAL_DATA_DIR --pane 0.003 --transmission 0.5 --interior 0.08

REAL_DATA_DIR has the folder `ouster` with the recordings; docs/ouster-twin.md says where they come from.
"""

import argparse
from dataclasses import replace
from pathlib import Path

from twin.comparison import compare
from twin.simulated import SENSOR
from twin.tables import count_table, heading_table, summary


def main() -> None:
    """Print the tables."""
    glass = SENSOR.glass
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="folder of the real recordings")
    parser.add_argument("--pane", type=float, default=glass.pane_reflectivity, help="reflectivity of a pane")
    parser.add_argument("--transmission", type=float, default=glass.transmission, help="transmission of a pane")
    parser.add_argument("--interior", type=float, default=glass.interior_reflectivity, help="reflectivity behind it")
    given = parser.parse_args()
    folder = given.folder / "ouster"
    if not folder.is_dir():
        parser.error(f"{folder}: no such folder; give the folder that contains `ouster`")
    glass = replace(
        glass,
        pane_reflectivity=given.pane,
        transmission=given.transmission,
        interior_reflectivity=given.interior,
    )
    compared = list(compare(folder, replace(SENSOR, glass=glass)))
    for table in (count_table(compared), summary(compared), heading_table(compared)):
        print(table, end="\n\n")


if __name__ == "__main__":
    main()
