"""Whether a track's id outlives the time for which its vehicle is hidden."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pandas as pd

from scenarios.grading.config import GradingConfig
from scenarios.grading.pairing import NO_TRACK
from scenarios.grading.sheet import MetricSheet

SHORT_S = 2.0
"""[s] up to which `track.hidden_2s_survival` counts an occlusion."""


def grade(sheet: MetricSheet, truth: pd.DataFrame, config: GradingConfig) -> None:
    """Enter the survival rates: occlusions after which the same track follows the vehicle, of all."""
    found = [
        episode
        for _, vehicle in truth.sort_values("frame", kind="stable").groupby("actor_id")
        for episode in episodes(vehicle, config)
    ]
    for name, longest_s in (("occlusion_survival", config.memory_s), ("hidden_2s_survival", SHORT_S)):
        survived = np.array([same_id for gap_s, same_id in found if gap_s <= longest_s], dtype=np.bool_)
        why = f"no followed vehicle was hidden and came back within {longest_s:g} s"
        sheet.mean(f"track.{name}", survived, why)


def episodes(vehicle: pd.DataFrame, config: GradingConfig) -> Iterator[tuple[float, bool]]:
    """Length [s] of each occlusion of one vehicle, its rows in the order of time, and whether its track survived.

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
    for last, again in pairwise(seen):
        if time[again] - time[last] > config.memory_s or not hidden[last + 1 : again].any():
            continue
        before, after = followed[followed <= last], followed[followed >= again]
        if len(before) and time[last] - time[before[-1]] <= config.memory_s:
            in_time = len(after) > 0 and time[after[0]] - time[again] <= config.memory_s
            yield float(time[again] - time[last]), bool(in_time and track[after[0]] == track[before[-1]])
