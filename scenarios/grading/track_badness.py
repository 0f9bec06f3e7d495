"""Badness of the estimates of tracks, row by row, by the errors that the metrics average."""

import numpy as np
import pandas as pd

from luxloop.scenarios.grading import track_errors
from luxloop.scenarios.grading.frame_badness import RatedRows, Row

VELOCITY = ("velocity_error_mps", "m/s off in its velocity")
ESTIMATES = {
    "velocity_abs_mean_mps": VELOCITY,
    "moving_velocity_abs_mean_mps": VELOCITY,
    "speed_abs_mean_mps": VELOCITY,
    "speed_mean_mps": VELOCITY,
    "standing_speed_mean_mps": ("speed_mps", "m/s fast"),
    "acceleration_abs_mean_mps2": ("acceleration_error_mps2", "m/s^2 off in its acceleration"),
    "standing_heading_abs_mean_deg": ("standing_heading_error_deg", "deg off in its track heading"),
    **dict.fromkeys(("length_mean_m", "length_abs_mean_m"), ("length_error_m", "m off in its length")),
    **dict.fromkeys(("width_mean_m", "width_abs_mean_m"), ("width_error_m", "m off in its width")),
}
"""Column of `track_errors.measure` and description of the error, by the metric's name without `track.`."""


def estimates(truth: pd.DataFrame, tracks: pd.DataFrame, measure: str) -> RatedRows:
    """Rate the tracks that one of `ESTIMATES` counts: on standing vehicles, on moving ones, or all."""
    column, words = ESTIMATES[measure]
    rows = track_errors.measure(truth, tracks)
    half = track_errors.modulo_half_turn(rows["heading_error_deg"].to_numpy())
    rows = rows.assign(standing_heading_error_deg=half)
    if measure.startswith(("standing", "moving", "acceleration")):
        rows = rows[rows["standing"] == measure.startswith("standing")]

    def describe(row: Row) -> str:
        return f"track {row['track_id']} on vehicle {row['vehicle']} is {row[column]:+.2f} {words}"

    return RatedRows(rows, np.abs(rows[column]), describe)
