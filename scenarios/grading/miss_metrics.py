"""Shares of missed vehicles: all, those that stand from first sight, and long ones."""

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Bools
from luxloop.scenarios.grading.bands import bands, why_none
from luxloop.scenarios.grading.clear_table import ClearTable
from luxloop.scenarios.grading.metric_sheet import MetricSheet
from luxloop.tracker.records import MODELS

LONG_M = 6.0
"""Length above which a vehicle is long [m]: trucks and buses, but no car or van of the usual sizes."""

NO_VEHICLE = "no vehicle was graded"


def grade(sheet: MetricSheet, clear: ClearTable, truth: pd.DataFrame) -> None:
    """Enter the shares of graded vehicles without a hit."""
    vehicles = clear.vehicles
    missed, actor = (~clear.is_hit).astype(np.float64), vehicles["actor_id"].to_numpy()
    for band, mask in bands(vehicles):
        why = why_none(band, NO_VEHICLE, len(vehicles))
        sheet.mean(f"track.missed_share{band}", missed[mask], why, None if band else actor[mask])
    standing, long = _standing_since_seen(vehicles, truth), vehicles["length_m"].to_numpy() > LONG_M
    why = "no graded vehicle stood when it came into sight"
    sheet.mean("track.missed_share_standing", missed[standing], why, actor[standing])
    why = f"no graded vehicle was longer than {LONG_M:g} m"
    sheet.mean("track.missed_share_long", missed[long], why, actor[long])


def _standing_since_seen(vehicles: pd.DataFrame, truth: pd.DataFrame) -> Bools:
    """(n,) mask of the graded rows of vehicles that have not moved since the first frame with a point on them."""
    first = truth[truth["points"] > 0].groupby("actor_id")["frame"].min()
    moving = truth[truth["mode"] != MODELS[0]]
    moving = moving[moving["frame"] >= moving["actor_id"].map(first)]
    starts = moving.groupby("actor_id")["frame"].min()
    return np.asarray(vehicles["frame"] < vehicles["actor_id"].map(starts).fillna(np.inf), dtype=np.bool_)
