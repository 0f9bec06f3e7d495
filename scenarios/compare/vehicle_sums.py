"""Sums of one run per vehicle, from which the metrics of any set of vehicles follow by addition."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.compare.truth_sums import truth_sums
from luxloop.scenarios.compare.vehicle_rows import VehicleRows
from luxloop.scenarios.grading import figures
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.observations import RunObservations
from luxloop.scenarios.grading.score_sums import hota_sums
from luxloop.scenarios.grading.tracking_scores import ALPHAS, VehicleScores
from luxloop.scenarios.metrics.definitions import DEFINITIONS, find_metric
from luxloop.sensor_model.truth import NO_ACTOR

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
