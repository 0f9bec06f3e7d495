"""Metrics of tracks: scores, missed vehicles, false tracks, and times until confirmation."""

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from luxloop.arrays import Floats, Ints
from luxloop.scenarios.grading import tracking_scores
from luxloop.scenarios.grading.clear_table import ClearTable, IdSwitch, TrackingSequence, id_switches
from luxloop.scenarios.grading.frame_tables import columns_of, rows_of_pairs
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
    time_s = clear.vehicles["time_s"].to_numpy(np.float64)
    in_time = np.argsort(clear.vehicles["frame"].to_numpy(), kind="stable")
    ids, earliest, vehicle = np.unique(
        clear.vehicles["actor_id"].to_numpy()[in_time], return_index=True, return_inverse=True
    )
    hits = np.flatnonzero(clear.is_hit[in_time])
    of_hit, first_hit = np.unique(vehicle[hits], return_index=True)
    first, hit_s = in_time[earliest], np.full(len(ids), np.inf)
    hit_s[of_hit] = time_s[in_time[hits[first_hit]]]  # NaN in files without times
    order = np.argsort(earliest)
    first, hit_s = first[order], hit_s[order]
    never = np.isinf(hit_s)
    return clear.vehicles.iloc[first].assign(never=never, wait_s=np.where(never, np.inf, hit_s - time_s[first]))


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


KEY = ("frame", "track_id")


def _grade_false(
    sheet: MetricSheet, clear: ClearTable, truth: pd.DataFrame, overlaps: pd.DataFrame, hit_iou_min: float
) -> None:
    """Enter the numbers of false tracks of each kind, and the share of all.

    The three kinds add up to `track.false`. Vehicles that are not graded count, too: a box on a part of them is not on
    nothing.
    """
    false = clear.tracks[~clear.hits]
    is_vehicle = truth["kind"].isin(CLASSES) | truth["graded"]  # graded boxes of files may be of any class
    frame, actor, iou = (overlaps[name].to_numpy() for name in ("frame", "actor_id", "iou"))
    of_vehicle = np.isin(actor, truth["actor_id"].to_numpy()[is_vehicle])
    graded = rows_of_pairs(frame, actor, *(clear.vehicles[name].to_numpy() for name in ("frame", "actor_id"))) >= 0
    row = rows_of_pairs(frame, overlaps["track_id"].to_numpy(), *(false[name].to_numpy() for name in KEY))
    nothing = _largest(iou, np.where(of_vehicle, row, -1), len(false)) == 0.0
    duplicate = _largest(iou, np.where(of_vehicle & graded, row, -1), len(false)) >= hit_iou_min
    counts = {"on_nothing": nothing, "ill_fitting": ~nothing & ~duplicate, "duplicate": duplicate}
    for name, rows in counts.items():
        sheet.write(f"track.false_{name}", int(rows.sum()), len(clear.tracks), NO_TRACK)
    sheet.rate("track.false_share", len(false), len(clear.vehicles), NO_VEHICLE)


def _largest(iou: Floats, row: Ints, tracks: int) -> Floats:
    """(tracks,) largest overlap of each track, 0 without any, from overlaps (m,) and their tracks' rows or -1."""
    largest = np.zeros(tracks)
    np.maximum.at(largest, row[row >= 0], iou[row >= 0])
    return largest


def measure(truth: pd.DataFrame, judged: pd.DataFrame) -> dict[str, npt.NDArray[Any]]:
    """Return further columns (K,) of the judged rows of the track table: their errors, and those of their vehicles.

    - `range_m`, `view`, `kind`: the vehicle's;
    - `standing`, `moving`: the true mode is stationary, or another one; neither if it is unknown;
    - `position_error_m`: distance of the centres;
    - `speed_mps`, `true_speed_mps`: norms of the velocities;
    - `velocity_error_mps`, `acceleration_error_mps2`: norms of the errors;
    - `length_error_m`, `width_error_m`: estimate minus truth.

    Missing estimates are NaN.

    Parameters
    ----------
    truth, judged
        Table of a run, and the judged rows of its table `tracks`.
    """
    keys = (table[name].to_numpy() for table in (judged, truth) for name in ("frame", "actor_id"))
    true = truth.reset_index(drop=True).reindex(rows_of_pairs(*keys))  # NaN where truth has no row
    velocity, acceleration = _corner_motion(judged, true)
    tracked_v, tracked_a = _pair(judged, "v{}_world_mps"), _pair(judged, "a{}_world_mps2")
    standing = (judged["true_mode"] == MODELS[0]).to_numpy(np.bool_)
    extent = columns_of(judged, EXTENT) - columns_of(true, EXTENT)
    return {
        **{name: true[name].to_numpy() for name in ("range_m", "view", "kind")},
        "standing": standing,
        "moving": judged["true_mode"].notna().to_numpy() & ~standing,
        "position_error_m": np.hypot(*(_pair(judged, "{}_world_m") - _pair(true, "{}_world_m")).T),
        "speed_mps": np.hypot(*tracked_v.T),
        "true_speed_mps": np.hypot(*velocity.T),
        "velocity_error_mps": np.hypot(*(tracked_v - velocity).T),
        "acceleration_error_mps2": np.hypot(*(tracked_a - acceleration).T),
        "length_error_m": extent[:, 0],
        "width_error_m": extent[:, 1],
    }


EXTENT = ("length_m", "width_m")


def modulo_half_turn(heading_error_deg: Floats) -> Floats:
    """Return heading errors modulo 180 degrees, in (-90, 90]."""
    return np.degrees(wrap(np.radians(heading_error_deg), np.pi))


def _corner_motion(judged: pd.DataFrame, true: pd.DataFrame) -> tuple[Floats, Floats]:
    """(K, 2) true velocity and acceleration of the tracked corner in world axes [m/s, m/s^2].

    The body is rigid: v = v_centre + w x r and a = a_centre - w^2 r, with the yaw rate w and the vector r from the
    centre to the corner. The change of the yaw rate is not known and left out.
    """
    half = 0.5 * columns_of(judged, ("corner_along", "corner_across")) * columns_of(true, EXTENT)
    to_corner = turned(half, true["yaw_world_rad"].to_numpy(np.float64))
    yaw_rate = true["yaw_rate_radps"].to_numpy(np.float64)[:, None]
    across = np.column_stack([-to_corner[:, 1], to_corner[:, 0]])
    velocity, acceleration = _pair(true, "v{}_world_mps"), _pair(true, "a{}_world_mps2")
    return velocity + yaw_rate * across, acceleration - yaw_rate**2 * to_corner


def _pair(rows: pd.DataFrame, column: str) -> Floats:
    """(K, 2) two columns, for x and y."""
    return columns_of(rows, (column.format(axis) for axis in "xy"))
