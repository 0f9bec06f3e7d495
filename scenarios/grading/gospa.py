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

from luxloop.scenarios.arrays import Floats, Ints

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
    rows = [
        pd.DataFrame({"frame": table["frame"].to_numpy(), name: np.arange(len(table))})
        for name, table in (("vehicle", vehicles), ("track", tracks))
    ]
    both = rows[0].merge(rows[1], on="frame")
    vehicle, track = both["vehicle"].to_numpy(), both["track"].to_numpy()
    apart = vehicles[POSITION].to_numpy(np.float64)[vehicle] - tracks[POSITION].to_numpy(np.float64)[track]
    squared = (apart**2).sum(axis=1)
    near = squared < cutoff_m**2
    return Assigned(vehicle[near], track[near], squared[near])


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
