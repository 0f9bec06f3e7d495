"""GOSPA of a run and its parts, overall and by range, class and view."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading import gospa
from luxloop.scenarios.grading.bands import WHOLE, bands, range_bands, why_none
from luxloop.scenarios.grading.metric_sheet import MetricSheet

NOTHING = "no vehicle was graded and no track was reported"
NO_RANGE = "an earlier version made the run, without the range of tracks"
PARTS = ("localisation", "missed", "false")


def grade(sheet: MetricSheet, vehicles: pd.DataFrame, tracks: pd.DataFrame, cutoff_m: float) -> None:
    """Enter the mean over all frames with a vehicle or a track.

    A band has the vehicles in it, and of false tracks those at its range: they have no class and no view.

    Parameters
    ----------
    vehicles
        Graded rows of the truth table.
    tracks
        Rows of the track table on graded vehicles, and false ones.
    cutoff_m
        `GradingConfig.gospa_cutoff_m`.
    """
    found = gospa.assign(vehicles, tracks, cutoff_m)
    located, missed = np.zeros(len(vehicles)), np.full(len(vehicles), 0.5 * cutoff_m**2)
    located[found.vehicle], missed[found.vehicle] = found.squared, 0.0
    false = np.delete(np.arange(len(tracks)), found.track)
    false_in = {band: mask[false] for band, mask in _track_bands(tracks)}
    ranged = bool(tracks["range_m"].notna().all())
    for band, mask in bands(vehicles):
        if band.startswith(".by_range") and not ranged:
            sheet.write(f"track.gospa_m{band}", None, 0, NO_RANGE)
            continue
        added = false[false_in.get(band, np.zeros(len(false), np.bool_))]
        frame = np.concatenate([vehicles["frame"].to_numpy()[mask], tracks["frame"].to_numpy()[added]])
        cost = _costs(located[mask], missed[mask], np.full(len(added), 0.5 * cutoff_m**2))
        parts = _sums(frame, cost)
        why = why_none(band, NOTHING, len(vehicles) + len(tracks))
        sheet.mean(f"track.gospa_m{band}", np.sqrt(parts.sum(axis=0)), why)
        if band == WHOLE:
            for name, part in zip(PARTS, parts, strict=True):
                sheet.mean(f"track.gospa_{name}_m2", part, why)


def _track_bands(tracks: pd.DataFrame) -> Iterator[tuple[str, Bools]]:
    """Yield the bands that a track has without a vehicle, with the masks (T,) of their tracks."""
    yield WHOLE, np.ones(len(tracks), np.bool_)
    yield from range_bands(tracks)


def _costs(located: Floats, missed: Floats, false: Floats) -> Floats:
    """(3, k + j) costs of localisation, missed vehicles and false tracks; k vehicles, then j false tracks [m^2]."""
    return np.block([[located, 0.0 * false], [missed, 0.0 * false], [0.0 * located, false]])


def _sums(frame: Ints, cost: Floats) -> Floats:
    """(parts, F) sums of the costs (parts, n) of each frame with rows, from the frames (n,) of the rows."""
    frames, row = np.unique(frame, return_inverse=True)
    return np.stack([np.bincount(row, part, len(frames)) for part in cost])
