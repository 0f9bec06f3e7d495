"""Whether a track's id outlives the time for which its vehicle is hidden, and how soon the vehicle is found again."""

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pandas as pd

from scenarios.grading.grading_config import GradingConfig
from scenarios.grading.matching import NO_TRACK
from scenarios.grading.metric_sheet import MetricSheet

SHORT_S = 2.0
"""[s] up to which `track.hidden_2s_survival` counts an occlusion."""


class Episode(NamedTuple):
    """One occlusion of a followed vehicle."""

    gap_s: float
    """[s] From the last frame in which it was graded to the next."""
    survived: bool
    """The track that followed it before follows it after."""
    reacquired_s: float
    """[s] From the end of the gap until a track follows it again; NaN if none does in time."""
    error_m: float
    """[m] From the centre of that track to the vehicle's, when it follows it again; NaN likewise."""


def grade(sheet: MetricSheet, truth: pd.DataFrame, tracks: pd.DataFrame, config: GradingConfig) -> None:
    """Enter the survival rates, how soon a vehicle is followed again, and where its track then is."""
    found = [episode for _, episode in by_vehicle(truth, tracks, config)]
    for name, longest_s in (("occlusion_survival", config.memory_s), ("hidden_2s_survival", SHORT_S)):
        survived = np.array([episode.survived for episode in found if episode.gap_s <= longest_s], dtype=np.bool_)
        why = f"no followed vehicle was hidden and came back within {longest_s:g} s"
        sheet.mean(f"track.{name}", survived, why)
    again = [episode for episode in found if np.isfinite(episode.reacquired_s)]
    why = "no followed vehicle was hidden, came back and was followed again"
    sheet.mean("track.reacquire_s", np.array([episode.reacquired_s for episode in again]), why)
    sheet.mean("track.reappearance_error_m", np.array([episode.error_m for episode in again]), why)


def by_vehicle(truth: pd.DataFrame, tracks: pd.DataFrame, config: GradingConfig) -> Iterator[tuple[int, Episode]]:
    """Yield the actor id and each of its occlusions, of the tables `truth` and `tracks` of a run."""
    place = ["frame", "track_id", "x_world_m", "y_world_m"]
    tracked = truth.merge(tracks[place], how="left", on=["frame", "track_id"], suffixes=("", "_track"))
    for actor_id, vehicle in tracked.sort_values("frame", kind="stable").groupby("actor_id"):
        for episode in _episodes(vehicle, config):
            yield int(actor_id), episode


def _episodes(vehicle: pd.DataFrame, config: GradingConfig) -> Iterator[Episode]:
    """Each occlusion of one vehicle: rows of `truth` in the order of time, joined with those of their tracks.

    An occlusion is a gap in the vehicle's grading of at most `memory_s`, in which it showed no more than
    `hidden_fraction_max` of itself, though alone it would have been seen. The track before it is the last that
    followed the vehicle while it was graded, the one after it the first, both at most `memory_s` away; without one
    before there is nothing to survive, without one after it did not.
    """
    graded = vehicle["graded"].to_numpy()
    time = vehicle["time_s"].to_numpy()
    track = np.where(graded, vehicle["track_id"].to_numpy(), NO_TRACK)
    followed = np.flatnonzero(track != NO_TRACK)
    dark = (vehicle["visible_fraction"] <= config.hidden_fraction_max) & (vehicle["hits_alone"] > 0)
    hidden = dark.to_numpy()
    seen = np.flatnonzero(graded)
    error = np.hypot(*(vehicle[f"{axis}_world_m_track"] - vehicle[f"{axis}_world_m"] for axis in "xy")).to_numpy()
    for last, again in pairwise(seen):
        if time[again] - time[last] > config.memory_s or not hidden[last + 1 : again].any():
            continue
        before, after = followed[followed <= last], followed[followed >= again]
        if not len(before) or time[last] - time[before[-1]] > config.memory_s:
            continue
        gap_s = float(time[again] - time[last])
        if len(after) and time[after[0]] - time[again] <= config.memory_s:
            same = bool(track[after[0]] == track[before[-1]])
            yield Episode(gap_s, same, float(time[after[0]] - time[again]), float(error[after[0]]))
        else:
            yield Episode(gap_s, False, np.nan, np.nan)
