"""Track the vehicles in a recording of LIDAR points. This needs only the package `tracker`, not the simulator.

python docs/examples/track_csv.py docs/examples/points.csv

A row is a point: time of its scan [s], its position in the ego frame [m], and the pose of the ego in the odometry frame
[m, m, rad]. Rows are sorted by scan and time.
"""

import sys
from itertools import pairwise
from math import degrees, hypot

import numpy as np

from luxloop.tracker.records import MODELS, Status
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import Tracker

TIME, POINT, POSE = 0, slice(1, 4), slice(4, 7)
EVERY = 10
"""Interval of printed scans."""


def scans(path):
    """Yield the scans of a CSV file with a header."""
    table = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
    starts = np.flatnonzero(np.diff(table[:, TIME], prepend=-np.inf))
    for start, end in pairwise([*starts, len(table)]):
        yield Scan.from_points(table[start, TIME], table[start:end, POINT], table[start, POSE])


def show(scan, boxes, tracks):
    """Print the boxes of a scan in the ego frame, and the tracks in the odometry frame."""
    print(f"{scan.time:.2f} s: {len(scan)} points, {len(boxes)} boxes, {len(tracks)} tracks")
    print("  box    x [m]   y [m]  heading [deg]  seen [m]")
    for b, (x, y) in enumerate(boxes.center_ego):
        along, across = boxes.size[b]
        print(f"  {b:3} {x:8.2f}{y:8.2f}{degrees(boxes.heading[b]):15.1f}{along:6.2f} x {across:.2f}")
    print("  track  x [m]   y [m]  heading [deg]  size [m]     speed [m/s]  model       status")
    for t, (x, y) in enumerate(tracks.center_odom):
        vx, vy, heading = tracks.mean[t, [2, 3, 6]]
        length, width = tracks.size[t]
        print(
            f"  {tracks.id[t]:3} {x:8.2f}{y:8.2f}{degrees(heading):15.1f}{length:6.2f} x {width:.2f}"
            f"{hypot(vx, vy):13.1f}  {MODELS[tracks.model[t]]:12}{Status(tracks.status[t]).name.lower()}"
        )


def main(path):
    """Track and print the result of every tenth scan."""
    tracker = Tracker()
    for number, scan in enumerate(scans(path), start=1):
        tracks, trace = tracker.step(scan)
        if number % EVERY == 0:
            show(scan, trace.boxes, tracks)


if __name__ == "__main__":
    main(sys.argv[1])
