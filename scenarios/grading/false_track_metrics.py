"""False tracks by what they are on: nothing, a vehicle that the box fits badly, or a vehicle with another track."""

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.grading.clear_table import ClearTable
from luxloop.scenarios.grading.metric_sheet import MetricSheet
from luxloop.scenarios.grading.track_metric_names import CLASSES

NO_VEHICLE = "no vehicle was graded"
NO_TRACK = "no track was reported in the graded range"
KEY = ["frame", "track_id"]


def grade(
    sheet: MetricSheet, clear: ClearTable, truth: pd.DataFrame, overlaps: pd.DataFrame, hit_iou_min: float
) -> None:
    """Enter the numbers of false tracks of each kind, and the share of all.

    The three kinds add up to `track.false`. Vehicles that are not graded count, too: a box on a part of them is not on
    nothing.

    Parameters
    ----------
    truth, overlaps
        Tables of the run.
    hit_iou_min
        Least overlap of a hit.
    """
    false = clear.tracks[~clear.hits]
    of_vehicle = overlaps[overlaps["actor_id"].isin(truth.loc[truth["kind"].isin(CLASSES), "actor_id"])]
    graded = of_vehicle.merge(clear.vehicles[["frame", "actor_id"]], on=["frame", "actor_id"])
    nothing = _largest(of_vehicle, false) == 0.0
    duplicate = _largest(graded, false) >= hit_iou_min
    counts = {"on_nothing": nothing, "ill_fitting": ~nothing & ~duplicate, "duplicate": duplicate}
    for name, rows in counts.items():
        sheet.write(f"track.false_{name}", int(rows.sum()), len(clear.tracks), NO_TRACK)
    sheet.rate("track.false_share", len(false), len(clear.vehicles), NO_VEHICLE)


def _largest(overlaps: pd.DataFrame, tracks: pd.DataFrame) -> Floats:
    """(n,) largest overlap of each track, 0 without any."""
    largest = overlaps.groupby(KEY)["iou"].max().reindex(pd.MultiIndex.from_frame(tracks[KEY]))
    return np.asarray(largest.fillna(0.0), dtype=np.float64)
