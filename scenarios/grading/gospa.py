"""Generalised optimal sub-pattern assignment (GOSPA) of tracks and vehicles, frame by frame.

Rahmathullah, Garcia-Fernandez and Svensson 2017, Generalized optimal sub-pattern assignment metric, with alpha = 2 and
p = 2 (equation 1 and proposition 1). With the cut-off c, the squared GOSPA of one frame is

    min over assignments of  sum d(vehicle, track)^2 + c^2 / 2 (missed vehicles + false tracks),

where d is the distance of the centres. A pair is worth assigning while d < c.
"""

from typing import NamedTuple

import numpy as np
import pandas as pd
import scipy

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading.clear_table import ClearTable
from luxloop.scenarios.grading.frame_tables import columns_of
from luxloop.scenarios.grading.metric_sheet import MetricSheet

POSITION = ["x_world_m", "y_world_m"]


class Assigned(NamedTuple):
    """Pairs of the optimal assignments of all frames."""

    vehicle: Ints
    """(K,) row of the vehicle."""
    track: Ints
    """(K,) row of the track."""
    squared: Floats
    """(K,) squared distance of the centres [m^2]."""


def assign(vehicles: pd.DataFrame, tracks: pd.DataFrame, cutoff_m: float) -> Assigned:
    """Assign tracks to vehicles in every frame.

    Most pairs are alone within the cut-off. The others need an assignment problem per frame.

    Parameters
    ----------
    vehicles, tracks
        Rows with `frame`, `x_world_m` and `y_world_m` [m].
    cutoff_m
        Distance c of the centres from which no pair is assigned [m].
    """
    close = _within(vehicles, tracks, cutoff_m)
    alone = (_times(close.vehicle) == 1) & (_times(close.track) == 1)
    frame = vehicles["frame"].to_numpy()[close.vehicle]
    chosen = [np.flatnonzero(alone)]
    for index in _groups(np.flatnonzero(~alone), frame):
        chosen.append(index[_best(close.vehicle[index], close.track[index], cutoff_m**2 - close.squared[index])])
    pairs = np.sort(np.concatenate(chosen))
    return Assigned(close.vehicle[pairs], close.track[pairs], close.squared[pairs])


def _within(vehicles: pd.DataFrame, tracks: pd.DataFrame, cutoff_m: float) -> Assigned:
    """Return all pairs of one frame with centres closer than the cut-off [m]."""
    vehicle, track = _in_one_frame(vehicles["frame"].to_numpy(), tracks["frame"].to_numpy())
    apart = columns_of(vehicles, POSITION)[vehicle] - columns_of(tracks, POSITION)[track]
    squared = (apart**2).sum(axis=1)
    near = squared < cutoff_m**2
    return Assigned(vehicle[near], track[near], squared[near])


def _in_one_frame(vehicle_frame: Ints, track_frame: Ints) -> tuple[Ints, Ints]:
    """Return the rows (K,) of the vehicle and of the track of all pairs with the same frame."""
    order = np.argsort(track_frame, kind="stable")
    first = np.searchsorted(track_frame, vehicle_frame, "left", order)
    last = np.searchsorted(track_frame, vehicle_frame, "right", order)
    vehicle = np.repeat(np.arange(len(vehicle_frame)), last - first)
    in_frame = np.arange(len(vehicle)) - np.repeat(np.cumsum(last - first) - (last - first), last - first)
    return vehicle, order[first[vehicle] + in_frame]


def _times(rows: Ints) -> Ints:
    """(K,) number of pairs with the row of each pair."""
    return np.bincount(rows)[rows] if len(rows) else rows


def _groups(index: Ints, frame: Ints) -> list[Ints]:
    """Return the pairs of `index` frame by frame."""
    index = index[np.argsort(frame[index], kind="stable")]
    starts = np.flatnonzero(np.diff(frame[index])) + 1
    return np.split(index, starts) if len(index) else []


def _best(vehicle: Ints, track: Ints, gain: Floats) -> Ints:
    """Return the indices of the pairs (K,) with the largest total gain, each vehicle and track at most once."""
    rows, row = np.unique(vehicle, return_inverse=True)
    columns, column = np.unique(track, return_inverse=True)
    pair = np.full((len(rows), len(columns)), -1)
    pair[row, column] = np.arange(len(vehicle))
    total = np.zeros(pair.shape)
    total[row, column] = gain
    found = pair[scipy.optimize.linear_sum_assignment(total, maximize=True)]
    return np.asarray(found[found >= 0])


NOTHING = "no vehicle was graded and no track was reported"
PARTS = ("localisation", "missed", "false")


def grade_gospa(sheet: MetricSheet, clear: ClearTable, cutoff_m: float, chosen: Bools, false_chosen: Bools) -> None:
    """Enter the mean over all frames with a chosen vehicle or false track.

    Parameters
    ----------
    clear
        Graded vehicles and counted tracks.
    cutoff_m
        `GradingConfig.gospa_cutoff_m`.
    chosen, false_chosen
        (n,) masks of the vehicles that count, and (m,) of the tracks that count if they are false.
    """
    vehicles, tracks = clear.vehicles, clear.tracks
    found = assign(vehicles, tracks, cutoff_m)
    located, missed = np.zeros(len(vehicles)), np.full(len(vehicles), 0.5 * cutoff_m**2)
    located[found.vehicle], missed[found.vehicle] = found.squared, 0.0
    is_false = np.ones(len(tracks), np.bool_)
    is_false[found.track] = False
    false = np.flatnonzero(is_false & false_chosen)
    frame = np.concatenate([vehicles["frame"].to_numpy()[chosen], tracks["frame"].to_numpy()[false]])
    cost = _costs(located[chosen], missed[chosen], np.full(len(false), 0.5 * cutoff_m**2))
    parts = _sums(frame, cost)
    sheet.mean("track.gospa_m", np.sqrt(parts.sum(axis=0)), NOTHING)
    for name, part in zip(PARTS, parts, strict=True):
        sheet.mean(f"track.gospa_{name}_m2", part, NOTHING)


def _costs(located: Floats, missed: Floats, false: Floats) -> Floats:
    """(3, k + j) costs of localisation, missed vehicles and false tracks; k vehicles, then j false tracks [m^2]."""
    return np.block([[located, 0.0 * false], [missed, 0.0 * false], [0.0 * located, false]])


def _sums(frame: Ints, cost: Floats) -> Floats:
    """(parts, F) sums of the costs (parts, n) of each frame with rows, from the frames (n,) of the rows."""
    frames, row = np.unique(frame, return_inverse=True)
    return np.stack([np.bincount(row, part, len(frames)) for part in cost])
