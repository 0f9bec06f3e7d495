"""Errors of velocity, acceleration, size and heading of every judged row of the track table."""

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.grading.plane_geometry import turned, wrap
from luxloop.tracker.records import MODELS

OF_VEHICLE = (
    "range_m",
    "view",
    "kind",
    "x_world_m",
    "y_world_m",
    "yaw_world_rad",
    "length_m",
    "width_m",
    "yaw_rate_radps",
)
OF_MOTION = ("vx_world_mps", "vy_world_mps", "ax_world_mps2", "ay_world_mps2")
"""Columns of the truth table that errors and filters need."""
OF_TRACK = (
    *("frame", "time_s", "track_id", "actor_id", "range_m", "true_mode"),
    *("x_world_m", "y_world_m", "yaw_world_rad", "length_m", "width_m"),
    *("heading_error_deg", "corner_along", "corner_across"),
)
"""Columns of the track table that errors need, beside those of the motion."""


def measure(truth: pd.DataFrame, tracks: pd.DataFrame) -> pd.DataFrame:
    """Return a row per judged row of the track table, with its errors.

    The columns are `frame`, `time_s`, `track_id`, `actor_id`, the vehicle's `range_m`, `view` and `kind`, and

    - `standing`, `moving`: the true mode is stationary, or another one; neither if it is unknown;
    - `position_error_m`: distance of the centres;
    - `speed_mps`, `true_speed_mps`: norms of the velocities;
    - `velocity_error_mps`, `acceleration_error_mps2`: norms of the errors;
    - `length_error_m`, `width_error_m`: estimate minus truth;
    - `heading_error_deg`: modulo 360, in (-180, 180].

    Missing estimates are NaN.

    Parameters
    ----------
    truth, tracks
        Tables of a run.
    """
    judged = tracks.loc[tracks["judged"], [*OF_TRACK, *OF_MOTION]]
    columns = ["frame", "actor_id", *OF_VEHICLE, *OF_MOTION]
    pair = judged.merge(truth[columns], how="left", on=["frame", "actor_id"], suffixes=("", "_true"))
    velocity, acceleration = _corner_motion(pair)
    tracked_v, tracked_a = _pair(pair, "v{}_world_mps"), _pair(pair, "a{}_world_mps2")
    return pd.DataFrame(
        {
            **{name: pair[name] for name in ("frame", "time_s", "track_id", "actor_id", "view", "kind")},
            "range_m": pair["range_m_true"],
            "standing": pair["true_mode"] == MODELS[0],
            "moving": pair["true_mode"].notna() & (pair["true_mode"] != MODELS[0]),
            "position_error_m": np.hypot(*(_pair(pair, "{}_world_m") - _pair(pair, "{}_world_m_true")).T),
            "speed_mps": np.hypot(*tracked_v.T),
            "true_speed_mps": np.hypot(*velocity.T),
            "velocity_error_mps": np.hypot(*(tracked_v - velocity).T),
            "acceleration_error_mps2": np.hypot(*(tracked_a - acceleration).T),
            "length_error_m": pair["length_m"] - pair["length_m_true"],
            "width_error_m": pair["width_m"] - pair["width_m_true"],
            "heading_error_deg": pair["heading_error_deg"],
        }
    )


def modulo_half_turn(heading_error_deg: Floats) -> Floats:
    """Return heading errors modulo 180 degrees, in (-90, 90]."""
    return np.degrees(wrap(np.radians(heading_error_deg), np.pi))


def _corner_motion(pair: pd.DataFrame) -> tuple[Floats, Floats]:
    """(K, 2) true velocity and acceleration of the tracked corner in world axes [m/s, m/s^2].

    The body is rigid: v = v_centre + w x r and a = a_centre - w^2 r, with the yaw rate w and the vector r from the
    centre to the corner. The change of the yaw rate is not known and left out.
    """
    sign = pair[["corner_along", "corner_across"]].to_numpy(np.float64)
    half = 0.5 * sign * pair[["length_m_true", "width_m_true"]].to_numpy(np.float64)
    to_corner = turned(half, pair["yaw_world_rad_true"].to_numpy(np.float64))
    yaw_rate = pair["yaw_rate_radps"].to_numpy(np.float64)[:, None]
    across = np.column_stack([-to_corner[:, 1], to_corner[:, 0]])
    velocity, acceleration = _pair(pair, "v{}_world_mps_true"), _pair(pair, "a{}_world_mps2_true")
    return velocity + yaw_rate * across, acceleration - yaw_rate**2 * to_corner


def _pair(rows: pd.DataFrame, column: str) -> Floats:
    """(K, 2) two columns, for x and y."""
    return np.asarray(rows[[column.format(axis) for axis in "xy"]], dtype=np.float64)
