"""Write docs/examples/points.csv: the LIDAR points of docs/examples/points.toml, and the ego pose of each scan.

python docs/export_points.py
"""

from pathlib import Path

import numpy as np
from blocks.steps import steps

EXAMPLES = Path(__file__).parent / "examples"
COLUMNS = ("time_s", "x_m", "y_m", "z_m", "ego_x_m", "ego_y_m", "ego_yaw_rad")
FORMAT = ("%.2f", "%.2f", "%.2f", "%.2f", "%.3f", "%.3f", "%.4f")
"""Points are rounded to 1 cm, the resolution of the units' ranges."""


def write(path: Path) -> None:
    """Run the scenario and write a row for each point."""
    rows = []
    for scan in (step.scan for step in steps(EXAMPLES / "points.toml")):
        pose = np.tile(scan.ego_pose_odom, (len(scan), 1))
        rows.append(np.column_stack([np.full(len(scan), scan.time), scan.points_ego, pose]))
    np.savetxt(path, np.concatenate(rows), FORMAT, ",", header=",".join(COLUMNS), comments="")


if __name__ == "__main__":
    write(EXAMPLES / "points.csv")
