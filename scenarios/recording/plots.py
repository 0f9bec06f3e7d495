"""Values of the plots of a recording for one frame."""

import numpy as np

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.grading.frame_grade import FrameGrade
from luxloop.sensor_model.truth import Cause, ScanTruth
from luxloop.sim.world import Actors, Mode
from luxloop.tracker.records import MODEL_NAMES, Status, Tracks


def plot_values(actors: Actors, truth: ScanTruth, tracks: Tracks, grade: FrameGrade) -> dict[str, Floats]:
    """Return the values of the lines of each plot in `blueprint.PLOTS`, by entity path."""
    confirmed, coasting = tracks.status == Status.CONFIRMED, tracks.status == Status.COASTING
    moving = actors.mode != Mode.STATIONARY
    on_moving = confirmed & np.isin(grade.track_actor, actors.id[moving])
    on_standing = confirmed & np.isin(grade.track_actor, actors.id[~moving])
    fit_error, track_error = grade.box_heading_error, grade.track_heading_error[confirmed]
    probability = by_model_name(tracks)
    noise = truth.cause != Cause.CLEAN
    return {
        "plots/models_moving": _mean(probability[on_moving]),
        "plots/models_standing": _mean(probability[on_standing]),
        "plots/heading_error": np.array([_median_abs_deg(fit_error), _median_abs_deg(track_error)]),
        "plots/counts": np.array([grade.graded.sum(), confirmed.sum(), coasting.sum()]),
        "plots/points": np.array([len(noise), noise.sum()]),
    }


def by_model_name(tracks: Tracks) -> Floats:
    """(T, len(MODEL_NAMES)) model probabilities; NaN for models that are not in the filter bank."""
    probability = np.full((len(tracks), len(MODEL_NAMES)), np.nan)
    probability[:, [MODEL_NAMES.index(model) for model in tracks.models]] = tracks.model_probability
    return probability


def _mean(rows: Floats) -> Floats:
    """Return the mean row; NaN without rows, which leaves a gap in the plot."""
    return rows.mean(axis=0) if len(rows) else np.full(rows.shape[1:], np.nan)


def _median_abs_deg(angles: Floats) -> float:
    angles = angles[np.isfinite(angles)]
    return float(np.rad2deg(np.median(np.abs(angles)))) if len(angles) else np.nan
