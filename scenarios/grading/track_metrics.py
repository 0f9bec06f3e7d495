"""Metrics of tracks: scores, missed vehicles, false tracks, and times until confirmation."""

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.grading import tracking_scores
from luxloop.scenarios.grading.clear_table import ClearTable, IdSwitch, TrackingSequence, id_switches
from luxloop.scenarios.grading.metric_sheet import MetricSheet
from luxloop.scenarios.grading.plane_geometry import turned, wrap
from luxloop.scenarios.grading.tracking_scores import VehicleScores
from luxloop.scenarios.metrics.definitions import CLASSES, NO_TRACK, NO_VEHICLE
from luxloop.sensor_model.truth import NO_ACTOR
from luxloop.tracker.records import MODELS

if TYPE_CHECKING:
    from luxloop.scenarios.grading.observations import RunObservations


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


KEY = ["frame", "track_id"]


def grade(sheet: MetricSheet, run: "RunObservations") -> None:
    """Enter every figure of the kind `score`."""
    sequence, clear = run.sequence, run.clear
    of_vehicles = VehicleScores.of(sequence, run.config.hit_iou_min, run.hits)
    scores = tracking_scores.TrackingScores.of(of_vehicles)
    followed = clear.tracks["actor_id"].where(clear.tracks["verdict"] == "graded", NO_ACTOR).to_numpy()
    interval = tracking_scores.intervals(sequence, of_vehicles, followed)
    vehicles, reported = sequence["num_gt_dets"], sequence["num_tracker_dets"]
    for name in ("hota", "deta", "assa", "mota", "idf1", "id_switches", "fragments", "missed"):
        value, found = getattr(scores, name), interval.get(f"track.{name}")
        sheet.write(f"track.{name}", value, vehicles, NO_VEHICLE, found, tracking_scores.why_no_interval(name, value))
    sheet.rate("track.id_switch_rate", scores.id_switches, vehicles, NO_VEHICLE)
    sheet.write("track.loca", scores.loca, scores.most_matches, "no track overlaps a graded vehicle")
    sheet.write("track.false", scores.false, reported, NO_TRACK)
    switches = id_switches(sequence["num_gt_ids"], run.hits)
    in_view = sum(_in_view(switch, sequence, run.truth, run.config.hidden_fraction_max) for switch in switches)
    sheet.write("track.id_switches_in_view", in_view, vehicles, NO_VEHICLE)
    _grade_false(sheet, clear, run.truth, run.tables["overlaps"], run.config.hit_iou_min)


def _in_view(switch: IdSwitch, sequence: TrackingSequence, truth: pd.DataFrame, hidden_fraction_max: float) -> bool:
    """Return True if the vehicle was in view from the last hit of the old track to the first of the new one.

    In view: present in every frame, with a visible fraction above `hidden_fraction_max` in each. The cause of a smaller
    fraction does not matter, be it an occluder or the rig's blind spot.
    """
    actor_id = sequence["actor_ids"][switch.vehicle]
    first, last = sequence["frames"][switch.before], sequence["frames"][switch.step]
    between = truth[(truth["actor_id"] == actor_id) & truth["frame"].between(first, last)]
    visible = between["visible_fraction"] > hidden_fraction_max
    return len(between) == last - first + 1 and bool(visible.all())


def _grade_false(
    sheet: MetricSheet, clear: ClearTable, truth: pd.DataFrame, overlaps: pd.DataFrame, hit_iou_min: float
) -> None:
    """Enter the numbers of false tracks of each kind, and the share of all.

    The three kinds add up to `track.false`. Vehicles that are not graded count, too: a box on a part of them is not on
    nothing.
    """
    false = clear.tracks[~clear.hits]
    is_vehicle = truth["kind"].isin(CLASSES) | truth["graded"]  # graded boxes of files may be of any class
    of_vehicle = overlaps[overlaps["actor_id"].isin(truth.loc[is_vehicle, "actor_id"])]
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
