"""Sums of one run per vehicle, from which the metrics of any set of vehicles follow by addition."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.compare.truth_sums import truth_sums
from luxloop.scenarios.compare.vehicle_rows import VehicleRows
from luxloop.scenarios.grading import mode_metrics, occlusion_metrics
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.score_sums import hota_sums
from luxloop.scenarios.grading.tracking_scores import ALPHAS, VehicleScores
from luxloop.scenarios.grading.tracking_sequence import tracking_sequence
from luxloop.sensor_model.truth import NO_ACTOR
from luxloop.tracker.records import MODELS

SUMS = (
    *("observations", "reported", "hits", "switches", "identified"),
    *("fitted", "fit_heading_deg", "fit_position_m"),
    *("moving", "flipped", "heading_deg", "moving_x_m", "moving_y_m"),
    *("standing", "standing_x_m", "standing_y_m", "right_mode"),
    *("segmented", "split", "in_no_segment", "segments", "merged"),
    *("occlusions", "survived"),
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
    truth, tracks = tables["truth"], tables["tracks"]
    graded, judged = truth[truth["graded"]], tracks[tracks["judged"]]
    rows = VehicleRows.of(truth)
    tracking, matches = _tracking(rows, tables, config)
    sums = {
        "observations": rows.sum(graded["actor_id"]),
        **tracking,
        **_fits(rows, tables["fits"]),
        **_positions(rows, judged),
        **_headings(rows, judged),
        **_segmentation(rows, graded, tables["segments"], config),
        **_occlusions(rows, tables, config),
    }
    column = np.column_stack([sums[name] for name in SUMS])
    return VehicleSums(rows.vehicle, _rounded(column), matches, truth_sums(rows, truth))


def _tracking(
    rows: VehicleRows, tables: Mapping[str, pd.DataFrame], config: GradingConfig
) -> tuple[dict[str, Floats], Ints]:
    """Summands of HOTA, CLEAR and Identity; reported tracks that follow no graded vehicle count for `NO_ACTOR`."""
    sequence = tracking_sequence(tables["truth"], tables["tracks"], tables["overlaps"])
    scores, vehicle = VehicleScores.of(sequence, config.hit_iou_min), sequence["actor_ids"]
    reported = tables["tracks"]
    reported = reported[reported["verdict"].isin(["graded", "false"])]
    of_actor = np.where(reported["verdict"] == "graded", reported["actor_id"], NO_ACTOR)
    found = scores.pairs
    pairs = np.column_stack([vehicle[found.vehicle], scores.track_frames[found.track], found.matches])
    return {
        "reported": rows.sum(of_actor),
        "hits": rows.sum(vehicle, scores.hits),
        "switches": rows.sum(vehicle, scores.id_switches),
        "identified": rows.sum(vehicle, scores.identified),
    }, pairs


def _fits(rows: VehicleRows, fits: pd.DataFrame) -> dict[str, Floats]:
    """Errors of the selected rectangles, as in `grading.fit_metrics`."""
    best = fits[fits["best"] & np.isfinite(fits["heading_error_deg"])]
    return {
        "fitted": rows.sum(best["actor_id"]),
        "fit_heading_deg": rows.sum(best["actor_id"], best["heading_error_deg"].abs()),
        "fit_position_m": rows.sum(best["actor_id"], best["position_error_m"]),
    }


def _positions(rows: VehicleRows, judged: pd.DataFrame) -> dict[str, Floats]:
    """Position errors and correct modes of judged tracks, as in `grading.mma_metrics` and `grading.mode_metrics`."""
    right = mode_metrics.described_mode(judged["model"]) == judged["true_mode"].cat.codes.to_numpy()
    sums = {"right_mode": rows.sum(judged["actor_id"], right)}
    stands = judged["true_mode"] == MODELS[0]
    for target, seen in (("standing", judged[stands]), ("moving", judged[~stands])):
        sums[target] = rows.sum(seen["actor_id"])
        for axis in "xy":
            sums[f"{target}_{axis}_m"] = rows.sum(seen["actor_id"], seen[f"mma_{axis}_error_m"].abs())
    return sums


def _headings(rows: VehicleRows, judged: pd.DataFrame) -> dict[str, Floats]:
    """Flipped headings of moving vehicles, as in `grading.track_metrics`, and the errors of the others."""
    moving = judged[judged["true_mode"] != MODELS[0]]
    error = moving["heading_error_deg"].abs()
    flipped = error > 90.0
    return {
        "flipped": rows.sum(moving["actor_id"], flipped),
        "heading_deg": rows.sum(moving["actor_id"], error.where(~flipped, 0.0)),
    }


def _segmentation(
    rows: VehicleRows, graded: pd.DataFrame, segments: pd.DataFrame, config: GradingConfig
) -> dict[str, Floats]:
    """Split and missed vehicles, and merged segments, as in `grading.segmentation_metrics`."""
    seen = graded[graded["largest_segment_share"].notna()]
    return {
        "segmented": rows.sum(seen["actor_id"]),
        "split": rows.sum(seen["actor_id"], seen["segments"] >= 2),
        "in_no_segment": rows.sum(seen["actor_id"], seen["largest_segment_share"] <= 0.5),
        "segments": rows.sum(segments["actor_id"]),
        "merged": rows.sum(segments["actor_id"], segments["second_share"] >= config.part_share_min),
    }


def _occlusions(rows: VehicleRows, tables: Mapping[str, pd.DataFrame], config: GradingConfig) -> dict[str, Floats]:
    """Occlusions, and those that the track id survived, as in `grading.occlusion_metrics`."""
    found = [
        (vehicle, occlusion.survived)
        for vehicle, occlusion in occlusion_metrics.occlusions(tables["truth"], tables["tracks"], config)
    ]
    vehicle, survived = np.reshape(found, (-1, 2)).T
    return {"occlusions": rows.sum(vehicle), "survived": rows.sum(vehicle, survived)}


def _rounded(sums: Floats) -> Floats:
    """Round to `DIGITS` significant digits through decimal text, so that a baseline file returns the same numbers."""
    return np.array([[float(f"{value:.{DIGITS}g}") for value in row] for row in sums.tolist()])
