"""Survival of track ids through occlusions of their vehicles, and time and error of reacquisition."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd

from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.occlusion_gaps import gaps


class Occlusion(NamedTuple):
    """Occlusion of a followed vehicle."""

    time_s: float
    """Time of the last graded frame before the occlusion [s]."""
    gap_s: float
    """Time from the last graded frame before to the first after the occlusion [s]."""
    survived: bool
    """True if the same track follows the vehicle before and after."""
    reacquired_s: float
    """Time from the end of the gap until a track follows the vehicle [s]; NaN if none does in time."""
    error_m: float
    """Distance of that track's centre from the vehicle's in that frame [m]; NaN if there is no such track."""


def occlusions(truth: pd.DataFrame, tracks: pd.DataFrame, config: GradingConfig) -> Iterator[tuple[int, Occlusion]]:
    """Yield every occlusion with the id of its actor, from the tables `truth` and `tracks` of a run."""
    place = ["frame", "track_id", "x_world_m", "y_world_m"]
    columns = [*place, "actor_id", "time_s", "graded", "visible_fraction", "hits_alone"]
    tracked = truth[columns].merge(tracks[place], how="left", on=["frame", "track_id"], suffixes=("", "_track"))
    for actor_id, vehicle in tracked.sort_values("frame", kind="stable").groupby("actor_id"):
        for occlusion in _of_vehicle(vehicle, config):
            yield int(actor_id), occlusion


def _of_vehicle(vehicle: pd.DataFrame, config: GradingConfig) -> Iterator[Occlusion]:
    """Yield each occlusion of at most `memory_s` of one vehicle, from its rows of `truth` joined with its tracks.

    Without a track after the gap, the id did not survive.
    """
    track, time = vehicle["track_id"].to_numpy(), vehicle["time_s"].to_numpy()
    error = np.hypot(*(vehicle[f"{axis}_world_m_track"] - vehicle[f"{axis}_world_m"] for axis in "xy")).to_numpy()
    for last, again, before, after in gaps(vehicle, config, config.memory_s):
        start, gap_s = float(time[last]), float(time[again] - time[last])
        if after is None:
            yield Occlusion(start, gap_s, False, np.nan, np.nan)
        else:
            same = bool(track[after] == track[before])
            yield Occlusion(start, gap_s, same, float(time[after] - time[again]), float(error[after]))
