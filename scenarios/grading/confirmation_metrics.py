"""Time from the first graded frame of a vehicle to the first frame in which a confirmed track hits it."""

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.grading.bands import bands, why_none
from luxloop.scenarios.grading.clear_table import ClearTable
from luxloop.scenarios.grading.metric_sheet import MetricSheet

NO_VEHICLE = "no vehicle was graded"
CENSORED = "too many vehicles were never confirmed"


def grade(sheet: MetricSheet, clear: ClearTable) -> None:
    """Enter median and 90th percentile over vehicles, and the share of those that are never confirmed.

    The latter count as infinite times. A quantile is an order statistic, without interpolation; an infinite one is no
    value. A band has the vehicles that are in it in their first graded frame.
    """
    found = waits(clear)
    wait = found["wait_s"].to_numpy()
    for band, mask in bands(found):
        _write(sheet, f"track.time_to_confirm_s{band}", wait[mask], 0.5, why_none(band, NO_VEHICLE, len(found)))
    _write(sheet, "track.time_to_confirm_p90_s", wait, 0.9, NO_VEHICLE)
    sheet.mean("track.never_confirmed", np.isinf(wait), NO_VEHICLE, found["actor_id"].to_numpy())


def waits(clear: ClearTable) -> pd.DataFrame:
    """Return a row per vehicle: that of its first graded frame, with `wait_s` until the first hit, or infinity [s]."""
    vehicles = clear.vehicles.sort_values("frame", kind="stable")
    first = vehicles.drop_duplicates("actor_id")
    hit = clear.vehicles[clear.is_hit].groupby("actor_id")["time_s"].min()
    wait = first["actor_id"].map(hit) - first["time_s"]
    return first.assign(wait_s=wait.fillna(np.inf).astype(np.float64))


def _write(sheet: MetricSheet, name: str, wait: Floats, share: float, why: str) -> None:
    value = float(np.quantile(wait, share, method="inverted_cdf")) if len(wait) else np.inf
    known = bool(np.isfinite(value))
    sheet.write(name, value if known else None, len(wait), CENSORED if len(wait) else why)
