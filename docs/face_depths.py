"""Print histograms of the depth of single faces, of vehicles and of background, from recorded scans.

    luxloop run paper-campus --seed 1 --record-scans --out runs/campus
    python docs/face_depths.py runs/campus

The densities of `tracker/vehicle_classes.py` follow them. They were made with seed 1 of paper-campus,
motorway-jam, queue-discharge, bus-stop, t-junction and highway-v0, and seed 2 of sumo-crossing.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from luxloop.scenarios.offline.recorded_scans import RecordedRun
from luxloop.sensor_model.truth import NO_ACTOR, ScanTruth
from luxloop.tracker.detection.detector import Detector
from luxloop.tracker.records import Boxes, Segments

EDGES_M = (0.0, 0.02, 0.04, 0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0, 1.3, 1.6, 2.2, 3.0)
"""Edges of the bins [m]."""
EVERY = 4
"""Every n-th scan is used: successive ones are alike."""
OWN_SHARE_MIN = 0.9
"""Minimum share of a segment's points on its object."""
SINGLE = ("side", "front", "rear")
"""Views of a single face."""
LORRIES = ("bus", "truck", "trailer_truck")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="+", help="folder of a run with recorded scans")
    rows = pd.concat([depths(RecordedRun.open(folder)) for folder in parser.parse_args().folder])
    single = rows["view"].isin(SINGLE)
    lorry = rows["kind"].isin(LORRIES)
    groups = {
        "car": rows[single & ~lorry], "lorry": rows[single & lorry], "background": rows[rows["actor_id"] == NO_ACTOR],
    }  # fmt: skip
    table = {
        f"{name} [1/m]": np.histogram(some["depth_m"], EDGES_M)[0] / len(some) / np.diff(EDGES_M)
        for name, some in groups.items()
    }
    print(pd.DataFrame({"from [m]": EDGES_M[:-1], "to [m]": EDGES_M[1:], **table}).round(2).to_string(index=False))
    print(", ".join(f"{name}: {len(some)} segments" for name, some in groups.items()))


def depths(run: RecordedRun) -> pd.DataFrame:
    """Return the depth of every box of a run, with the object that its segment is on."""
    truth = run.result.tables["truth"][["frame", "actor_id", "view", "kind"]]
    detector = Detector(run.scenario.tracker)
    rows = []
    for number, (_, scan, scan_truth) in enumerate(run.scans()):
        found = detector.step(scan)
        if number % EVERY == 0:
            rows += [(number, *row) for row in owned(found.segments, found.boxes, scan_truth)]
    table = pd.DataFrame(rows, columns=["frame", "actor_id", "depth_m"])
    return table.merge(truth, how="left", on=["frame", "actor_id"])


def owned(segments: Segments, boxes: Boxes, truth: ScanTruth) -> Iterator[tuple[int, float]]:
    """Yield the object of each box whose segment lies on one object, and the smaller visible extent [m]."""
    for segment, size in zip(boxes.segment.tolist(), boxes.size, strict=True):
        actor, points = np.unique(truth.actor_id[segments.label == segment], return_counts=True)
        if points.max() >= OWN_SHARE_MIN * points.sum():
            yield int(actor[points.argmax()]), float(size.min())


if __name__ == "__main__":
    main()
