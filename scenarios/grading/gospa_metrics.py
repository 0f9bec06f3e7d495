"""GOSPA of a run and its parts."""

import numpy as np

from luxloop.scenarios.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading import gospa
from luxloop.scenarios.grading.clear_table import ClearTable
from luxloop.scenarios.grading.metric_sheet import MetricSheet

NOTHING = "no vehicle was graded and no track was reported"
NO_RANGE = "an earlier version made the run, without the range of tracks"
PARTS = ("localisation", "missed", "false")


def grade(
    sheet: MetricSheet, clear: ClearTable, cutoff_m: float, chosen: Bools, false_chosen: Bools, *, ranged: bool
) -> None:
    """Enter the mean over all frames with a chosen vehicle or false track.

    Parameters
    ----------
    clear
        Graded vehicles and counted tracks.
    cutoff_m
        `GradingConfig.gospa_cutoff_m`.
    chosen, false_chosen
        (n,) masks of the vehicles that count, and (m,) of the tracks that count if they are false.
    ranged
        False if tracks are chosen by their range, and it is not known.
    """
    vehicles, tracks = clear.vehicles, clear.tracks
    found = gospa.assign(vehicles, tracks, cutoff_m)
    located, missed = np.zeros(len(vehicles)), np.full(len(vehicles), 0.5 * cutoff_m**2)
    located[found.vehicle], missed[found.vehicle] = found.squared, 0.0
    is_false = np.ones(len(tracks), np.bool_)
    is_false[found.track] = False
    false = np.flatnonzero(is_false & false_chosen)
    frame = np.concatenate([vehicles["frame"].to_numpy()[chosen], tracks["frame"].to_numpy()[false]])
    cost = _costs(located[chosen], missed[chosen], np.full(len(false), 0.5 * cutoff_m**2))
    parts = _sums(frame, cost) if ranged else np.empty((len(PARTS), 0))
    sheet.mean("track.gospa_m", np.sqrt(parts.sum(axis=0)), NOTHING if ranged else NO_RANGE)
    for name, part in zip(PARTS, parts, strict=True):
        sheet.mean(f"track.gospa_{name}_m2", part, NOTHING if ranged else NO_RANGE)


def _costs(located: Floats, missed: Floats, false: Floats) -> Floats:
    """(3, k + j) costs of localisation, missed vehicles and false tracks; k vehicles, then j false tracks [m^2]."""
    return np.block([[located, 0.0 * false], [missed, 0.0 * false], [0.0 * located, false]])


def _sums(frame: Ints, cost: Floats) -> Floats:
    """(parts, F) sums of the costs (parts, n) of each frame with rows, from the frames (n,) of the rows."""
    frames, row = np.unique(frame, return_inverse=True)
    return np.stack([np.bincount(row, part, len(frames)) for part in cost])
