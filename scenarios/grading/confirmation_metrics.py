"""Time from the first graded frame of a vehicle to the first frame in which a confirmed track hits it."""

import numpy as np
import pandas as pd

from luxloop.scenarios.grading.clear_table import ClearTable


def waits(clear: ClearTable) -> pd.DataFrame:
    """Return a row per vehicle: that of its first graded frame, with `wait_s` until the first hit, or infinity [s]."""
    vehicles = clear.vehicles.sort_values("frame", kind="stable")
    first = vehicles.drop_duplicates("actor_id")
    hit = clear.vehicles[clear.is_hit].groupby("actor_id")["time_s"].min()
    wait = first["actor_id"].map(hit) - first["time_s"]
    return first.assign(wait_s=wait.fillna(np.inf).astype(np.float64))
