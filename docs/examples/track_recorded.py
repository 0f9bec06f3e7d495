"""Track a recorded run: read scans from Parquet files and write tracks to a CSV file.

luxloop run docs/examples/my-first.toml --record-scans --out recorded
python docs/examples/track_recorded.py recorded tracks.csv
luxloop grade recorded --tracks tracks.csv
"""

import sys
from pathlib import Path

import pandas as pd
from my_tracker import CAR_M, PatchTracker

PLACE = ["x_ego_m", "y_ego_m", "z_ego_m"]
POSE = ["odom_x_m", "odom_y_m", "odom_yaw_rad"]


def main(run, out):
    """Track the scans of a run and write a row per track and frame."""
    scans = pd.read_parquet(Path(run, "scans", "scans.parquet")).set_index("frame")
    points = pd.read_parquet(Path(run, "scans", "points.parquet"), columns=["frame", *PLACE])
    tracker, tracks = PatchTracker(None), []
    for frame, pose in scans[POSE].iterrows():
        seen = points.loc[points["frame"] == frame, PLACE].to_numpy()
        ids, centers = tracker.follow(seen, pose.to_numpy())
        found = {"frame": frame, "track_id": ids, "x_odom_m": centers[:, 0], "y_odom_m": centers[:, 1]}
        tracks.append(pd.DataFrame(found).assign(heading_odom_rad=pose["odom_yaw_rad"]))
    pd.concat(tracks).assign(length_m=CAR_M[0], width_m=CAR_M[1]).to_csv(out, index=False)


if __name__ == "__main__":
    main(*sys.argv[1:])
