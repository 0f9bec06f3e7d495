"""Metrics of the motion, size and heading of tracks on graded vehicles, overall and by range, class and view."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Bools, Floats
from luxloop.scenarios.grading import track_errors
from luxloop.scenarios.grading.bands import WHOLE, bands, why_none
from luxloop.scenarios.grading.metric_sheet import MetricSheet
from luxloop.scenarios.grading.track_metric_names import BANDED_NAMES

NO_PAIR = "no confirmed track followed a graded vehicle"
UNKNOWN = "the tracker does not report this estimate, or an earlier version made the run"


class Figure(NamedTuple):
    """A mean over rows of track errors."""

    name: str
    rows: Bools
    """(K,) mask of the rows that count."""
    values: Floats
    """(K,) value of each row; NaN if it is not known."""
    what: str = NO_PAIR
    """Reason without rows."""


def grade(sheet: MetricSheet, truth: pd.DataFrame, tracks: pd.DataFrame) -> None:
    """Enter velocity, acceleration, size and heading errors from the tables `truth` and `tracks`."""
    errors = track_errors.measure(truth, tracks)
    actor = errors["actor_id"].to_numpy()
    masks = list(bands(errors))
    for figure in figures(errors):
        known = figure.rows & np.isfinite(figure.values)
        why = UNKNOWN if figure.rows.any() else figure.what
        for band, mask in masks if figure.name in BANDED_NAMES else [(WHOLE, known)]:
            rows, reason = known & mask, why_none(band, why, int(known.sum()))
            vehicle = None if band else actor[rows]
            sheet.mean(f"{figure.name}{band}", figure.values[rows], reason, vehicle)
    _grade_p90(sheet, errors)


def figures(errors: pd.DataFrame) -> Iterator[Figure]:
    """Yield every mean over rows of track errors."""
    every = np.ones(len(errors), np.bool_)
    standing, heading = (errors[name].to_numpy() for name in ("standing", "heading_error_deg"))
    speed, true_speed = (errors[f"{name}_mps"].to_numpy() for name in ("speed", "true_speed"))
    velocity, acceleration = (errors[name].to_numpy() for name in ("velocity_error_mps", "acceleration_error_mps2"))
    moves, stands = (f"{NO_PAIR} that was {what}" for what in ("moving", "standing"))
    half = track_errors.modulo_half_turn(heading)
    yield Figure("track.heading_abs_mean_deg", ~standing, np.abs(heading), moves)
    yield Figure("track.heading_flip_rate", ~standing, (np.abs(heading) > 90.0).astype(np.float64), moves)
    yield Figure("track.standing_heading_abs_mean_deg", standing, np.abs(half), stands)
    yield Figure("track.velocity_abs_mean_mps", every, velocity)
    yield Figure("track.moving_velocity_abs_mean_mps", ~standing, velocity, moves)
    yield Figure("track.standing_speed_mean_mps", standing, speed, stands)
    yield Figure("track.speed_abs_mean_mps", every, np.abs(speed - true_speed))
    yield Figure("track.speed_mean_mps", every, speed - true_speed)
    yield Figure("track.acceleration_abs_mean_mps2", ~standing, acceleration, moves)
    for name in ("length", "width"):
        error = errors[f"{name}_error_m"].to_numpy()
        yield Figure(f"track.{name}_mean_m", every, error)
        yield Figure(f"track.{name}_abs_mean_m", every, np.abs(error))


def _grade_p90(sheet: MetricSheet, errors: pd.DataFrame) -> None:
    """Enter the 90th percentile of the heading errors of moving vehicles."""
    error = errors.loc[~errors["standing"], "heading_error_deg"].abs().to_numpy()
    value = float(np.quantile(error, 0.9)) if len(error) else None
    sheet.write("track.heading_abs_p90_deg", value, len(error), f"{NO_PAIR} that was moving")
