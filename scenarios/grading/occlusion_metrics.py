"""Survival of track ids through occlusions of their vehicles, and time and error of reacquisition."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd

from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.metric_sheet import MetricSheet
from luxloop.scenarios.grading.occlusion_gaps import gaps

SHORT_S = 2.0
"""Longest occlusion that `track.hidden_2s_survival` counts [s]."""


class Occlusion(NamedTuple):
    """Occlusion of a followed vehicle."""

    gap_s: float
    """Time from the last graded frame before to the first after the occlusion [s]."""
    survived: bool
    """True if the same track follows the vehicle before and after."""
    reacquired_s: float
    """Time from the end of the gap until a track follows the vehicle [s]; NaN if none does in time."""
    error_m: float
    """Distance of that track's centre from the vehicle's in that frame [m]; NaN if there is no such track."""


def grade(sheet: MetricSheet, truth: pd.DataFrame, tracks: pd.DataFrame, config: GradingConfig) -> None:
    """Enter the survival rates, and the time and error of reacquisition, from the tables of a run."""
    found = [occlusion for _, occlusion in occlusions(truth, tracks, config)]
    for name, longest_s in (("occlusion_survival", config.memory_s), ("hidden_2s_survival", SHORT_S)):
        survived = np.array([occlusion.survived for occlusion in found if occlusion.gap_s <= longest_s], dtype=np.bool_)
        why = f"no followed vehicle was hidden and came back within {longest_s:g} s"
        sheet.mean(f"track.{name}", survived, why)
    again = [occlusion for occlusion in found if np.isfinite(occlusion.reacquired_s)]
    why = "no followed vehicle was hidden, came back and was followed again"
    sheet.mean("track.reacquire_s", np.array([occlusion.reacquired_s for occlusion in again]), why)
    sheet.mean("track.reappearance_error_m", np.array([occlusion.error_m for occlusion in again]), why)


def occlusions(truth: pd.DataFrame, tracks: pd.DataFrame, config: GradingConfig) -> Iterator[tuple[int, Occlusion]]:
    """Yield every occlusion with the id of its actor, from the tables `truth` and `tracks` of a run."""
    place = ["frame", "track_id", "x_world_m", "y_world_m"]
    tracked = truth.merge(tracks[place], how="left", on=["frame", "track_id"], suffixes=("", "_track"))
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
        gap_s = float(time[again] - time[last])
        if after is None:
            yield Occlusion(gap_s, False, np.nan, np.nan)
        else:
            same = bool(track[after] == track[before])
            yield Occlusion(gap_s, same, float(time[after] - time[again]), float(error[after]))
