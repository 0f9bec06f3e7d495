"""Sums of one run per vehicle, from which the metrics of any set of vehicles follow by addition.

Means of the truth per vehicle recognise the same vehicle in two runs. The last bits of simulated values may depend on
the processor and the C library. A hash of the truth would differ, and so would a hash of rounded values whenever one of
them lies at a border of rounding. Means are compared within tolerances.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import pandas as pd

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading import figures
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.observations import RunObservations
from luxloop.scenarios.grading.tracking_scores import ALPHAS, VehicleScores, hota_sums
from luxloop.scenarios.metrics.definitions import DEFINITIONS, find_metric
from luxloop.sensor_model.truth import NO_ACTOR


class VehicleRows(NamedTuple):
    """Row of each vehicle; actors that were never graded share the row of `NO_ACTOR`, the first."""

    vehicle: Ints
    """(V,) ids, ascending."""

    @classmethod
    def of(cls, truth: pd.DataFrame) -> "VehicleRows":
        """Return the rows of the vehicles that the truth table calls graded in any frame."""
        return cls(np.union1d([NO_ACTOR], truth.loc[truth["graded"], "actor_id"]))

    def sum(self, actor_id: npt.ArrayLike, values: npt.ArrayLike | None = None) -> Floats:
        """(V,) sums of values (n,) of actors (n,), or numbers of rows without values."""
        actor_id = np.asarray(actor_id, dtype=np.int64)
        row = np.minimum(np.searchsorted(self.vehicle, actor_id), len(self.vehicle) - 1)
        row = np.where(self.vehicle[row] == actor_id, row, 0)
        weights = None if values is None else np.asarray(values, dtype=np.float64)
        return np.bincount(row, weights, len(self.vehicle)).astype(np.float64)


FURTHER = tuple(definition.name for definition in DEFINITIONS.values() if definition.compared)
"""Metrics that comparisons test because their definitions say so; the sums of each are its value and its weight."""

SUMS = (
    *("observations", "reported", "hits", "switches", "identified"),
    *("fitted", "fit_heading_deg", "fit_position_m"),
    *("moving", "flipped", "heading_deg", "moving_x_m", "moving_y_m"),
    *("standing", "standing_x_m", "standing_y_m", "right_mode"),
    *("segmented", "split", "in_no_segment", "segments", "merged"),
    *("occlusions", "survived"),
    *(f"{name} {sum_of}" for name in FURTHER for sum_of in ("part", "whole")),
)
"""Names of the sums over a vehicle's frames: counts, and absolute errors in the unit at the end of the name."""

COLUMNS = (*SUMS, *(f"matched_{alpha:.2f}" for alpha in ALPHAS), *(f"associated_{alpha:.2f}" for alpha in ALPHAS))
"""`SUMS`, then HOTA's true positives and their association scores at each overlap threshold."""

DIGITS = 7
"""Significant digits of a sum. Sums of run folders are rounded as those in baseline files."""


@dataclass(frozen=True, slots=True, eq=False)
class VehicleSums:
    """Sums of one run for V vehicles. The first row, `NO_ACTOR`, holds what belongs to no graded vehicle."""

    vehicle: Ints
    """(V,) ids, ascending."""
    sums: Floats
    """(V, len(SUMS))."""
    matches: Ints
    """(M, 2 + len(ALPHAS)) HOTA's pairs: vehicle, frames of the track, and frames in which they match, by the largest
    of `ALPHAS` that their overlap reaches."""
    truth: Floats
    """(V, len(TRUTH)) means of the truth, as from `truth_sums`."""

    def columns(self) -> Floats:
        """(V, len(COLUMNS)) sums."""
        row = np.searchsorted(self.vehicle, self.matches[:, 0])
        frames = self.sums[row, 0] + self.matches[:, 1]
        return np.hstack([self.sums, hota_sums(row, frames, self.matches[:, 2:], len(self.vehicle))])


def vehicle_sums(tables: Mapping[str, pd.DataFrame], config: GradingConfig) -> VehicleSums:
    """Add up the tables of a run per vehicle.

    Parameters
    ----------
    tables
        As in `luxloop.scenarios.grading.frame_tables`.
    config
        Limits of the run's grading.

    Raises
    ------
    KeyError
        A table or a column is missing.
    """
    truth, run = tables["truth"], RunObservations(tables, config, frames=0)
    rows = VehicleRows.of(truth)
    tracking, matches = _tracking(rows, run)
    sums = dict(tracking)
    for name, (part, whole) in {**OF_METRICS, **{name: (f"{name} part", f"{name} whole") for name in FURTHER}}.items():
        selection = find_metric(name)
        observations = run.of_kind(selection.definition.kind)
        counted = figures.counted(selection, observations)
        actor = observations["actor_id"][counted.row]
        sums |= {part: rows.sum(actor, counted.value), whole: rows.sum(actor, counted.weight)}
    column = np.column_stack([sums[name] for name in SUMS])
    return VehicleSums(rows.vehicle, _rounded(column), matches, truth_sums(rows, truth))


OF_METRICS = {
    "fit.heading_abs_mean_deg": ("fit_heading_deg", "fitted"),
    "fit.position_abs_mean_m": ("fit_position_m", "fitted"),
    "mma.x_abs_mean_m{target=moving}": ("moving_x_m", "moving"),
    "mma.y_abs_mean_m{target=moving}": ("moving_y_m", "moving"),
    "mma.x_abs_mean_m{target=standing}": ("standing_x_m", "standing"),
    "mma.y_abs_mean_m{target=standing}": ("standing_y_m", "standing"),
    "track.heading_unflipped_mean_deg": ("heading_deg", "unflipped"),
    "track.heading_flip_rate": ("flipped", "moving"),
    "mma.mode_accuracy": ("right_mode", "judged"),
    "segmentation.over_rate": ("split", "segmented"),
    "segmentation.missed_rate": ("in_no_segment", "segmented"),
    "segmentation.under_rate": ("merged", "segments"),
    "track.occlusion_survival": ("survived", "occlusions"),
}
"""Sums of the values and of the denominators of metrics, by the definitions of the metrics."""


def _tracking(rows: VehicleRows, run: RunObservations) -> tuple[dict[str, Floats], Ints]:
    """Summands of HOTA, CLEAR and Identity; reported tracks that follow no graded vehicle count for `NO_ACTOR`."""
    sequence = run.sequence
    scores, vehicle = VehicleScores.of(sequence, run.config.hit_iou_min, run.hits), sequence["actor_ids"]
    reported = run.tracks
    reported = reported[reported["verdict"].isin(["graded", "false"])]
    of_actor = np.where(reported["verdict"] == "graded", reported["actor_id"], NO_ACTOR)
    found = scores.pairs
    pairs = np.column_stack([vehicle[found.vehicle], scores.track_frames[found.track], found.matches])
    return {
        "observations": rows.sum(vehicle, scores.frames),
        "reported": rows.sum(of_actor),
        "hits": rows.sum(vehicle, scores.hits),
        "switches": rows.sum(vehicle, scores.id_switches),
        "identified": rows.sum(vehicle, scores.identified),
    }, pairs


def _rounded(sums: Floats) -> Floats:
    """Round to `DIGITS` significant digits through decimal text, so that a baseline file returns the same numbers."""
    return np.array([[float(f"{value:.{DIGITS}g}") for value in row] for row in sums.tolist()])


TRACKER_COLUMNS = ("track_id", "segments", "largest_segment_share")
"""Columns of the truth table that depend on the tracker."""

TRUTH = ("frames", "x_world_m", "y_world_m", "range_m", "points", "others")
"""Per vehicle: number of frames, means over them, and the mean of the weighted sum of all other columns."""

DECIMALS = 7
"""Decimals of a mean."""
ABSOLUTE = 1e-6
"""Tolerance of a mean, in the column's unit. Another CPU changes means by 1e-11 at most in the shipped catalog."""
RELATIVE = 1e-9
"""Tolerance of a large mean, as a share of it."""


def truth_sums(rows: VehicleRows, truth: pd.DataFrame) -> Floats:
    """Return the means (V, len(TRUTH)) of the truth table; actors that were never graded share the first row."""
    actor = truth["actor_id"]
    frames = rows.sum(actor)
    named = [np.nan_to_num(truth[name].to_numpy(np.float64)) for name in TRUTH[1:-1]]  # files may lack ranges
    used = {"frame", "actor_id", "name", *TRUTH, *TRACKER_COLUMNS}
    others = [_numbers(truth[name]) for name in truth.columns if name not in used]
    # Different weights, so that an exchange of two columns shows.
    weighted = sum((weight * column for weight, column in enumerate(others, start=1)), start=np.zeros(len(truth)))
    means = [rows.sum(actor, column) / np.maximum(frames, 1.0) for column in (*named, weighted)]
    rounded: Floats = np.column_stack([frames, *means]).round(DECIMALS)
    return rounded


def _numbers(column: "pd.Series[float]") -> Floats:
    """Return a column as continuous numbers: codes of categories, 0 for missing values, and no jumps at +-pi."""
    if isinstance(column.dtype, pd.CategoricalDtype):
        codes: Floats = column.cat.codes.to_numpy(np.float64)
        return codes
    values = np.nan_to_num(column.to_numpy(np.float64))
    numbers: Floats = np.cos(values) + 2.0 * np.sin(values) if str(column.name).endswith("_rad") else values
    return numbers


def counterparts(base: Ints, head: Ints, base_truth: Floats, head_truth: Floats) -> tuple[Ints, Ints]:
    """Return the rows of BASE and of HEAD of the vehicles with equal truth, in ascending order of their ids.

    Parameters
    ----------
    base, head
        (V,) and (W,) ids of the vehicles.
    base_truth, head_truth
        (V, len(TRUTH)) and (W, len(TRUTH)) as from `truth_sums`.
    """
    _, b, h = np.intersect1d(base, head, assume_unique=True, return_indices=True)
    same = close(base_truth[b], head_truth[h])
    return b[same].astype(np.int64), h[same].astype(np.int64)


def close(base: npt.NDArray[np.float64], head: npt.NDArray[np.float64]) -> Bools:
    """(V,) True for the rows (V, len(TRUTH)) that are equal within the tolerances."""
    return np.asarray(np.isclose(base, head, rtol=RELATIVE, atol=ABSOLUTE).all(axis=1))
