"""True manoeuvre of a vehicle in an interval of time."""

import numpy as np
import pandas as pd

from luxloop.scenarios.grading.plane_geometry import wrap

MANOEUVRES = ("keeps", "brakes", "accelerates", "turns", "changes lane")

TURN_DEG = 15.0
"""A vehicle whose heading changes by at least this angle turns: a lane change returns to its heading."""
STRAIGHT_DEG = 5.0
"""A vehicle that is `LANE_M` to the side with a smaller change of heading has changed its lane."""
LANE_M = 1.0
"""About a third of a lane."""
SPEEDING_MPS2 = 0.5
"""Least mean change of speed of a vehicle that brakes or accelerates; drivers vary their speed by less."""


def manoeuvre(rows: pd.DataFrame) -> str:
    """Return the manoeuvre, one of `MANOEUVRES`, between the first and the last of a vehicle's rows of `truth`.

    A turn counts before a lane change, and both before a change of speed.
    """
    first, last = rows.iloc[0], rows.iloc[-1]
    yaw = float(first["yaw_world_rad"])
    turned_deg = abs(float(np.degrees(wrap(np.array([last["yaw_world_rad"] - yaw]))[0])))
    x, y = last["x_world_m"] - first["x_world_m"], last["y_world_m"] - first["y_world_m"]
    aside_m = abs(-np.sin(yaw) * x + np.cos(yaw) * y)
    if turned_deg >= TURN_DEG:
        return "turns"
    if rows["changes_lane"].any() or (aside_m >= LANE_M and turned_deg < STRAIGHT_DEG):
        return "changes lane"
    duration_s = float(last["time_s"] - first["time_s"])
    speed = np.hypot(rows["vx_world_mps"].to_numpy(), rows["vy_world_mps"].to_numpy())
    change_mps2 = (speed[-1] - speed[0]) / duration_s if duration_s > 0 else 0.0
    if abs(change_mps2) >= SPEEDING_MPS2:
        return "brakes" if change_mps2 < 0 else "accelerates"
    return "keeps"
