"""Time from the first graded frame of a vehicle to the first frame in which a confirmed track hits it."""

import numpy as np
import pandas as pd

from luxloop.scenarios.grading.clear_table import ClearTable


def waits(clear: ClearTable) -> pd.DataFrame:
    """Return a row per vehicle: that of its first graded frame, with `wait_s` until the first hit [s].

    It is infinite, and `never` true, without a hit.
    """
    vehicles = clear.vehicles.sort_values("frame", kind="stable")
    first = vehicles.drop_duplicates("actor_id")
    hit = clear.vehicles[clear.is_hit].groupby("actor_id")["time_s"].min()
    never = ~first["actor_id"].isin(hit.index)
    wait = first["actor_id"].map(hit) - first["time_s"]
    return first.assign(never=never, wait_s=wait.astype(np.float64).mask(never, np.inf))
