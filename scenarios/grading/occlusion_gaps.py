"""Gaps in the grading of a followed vehicle in which it is hidden."""

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pandas as pd

from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.matching import NO_TRACK


class Gap(NamedTuple):
    """An occlusion, as rows of one vehicle's part of the table `truth` in time order."""

    last: int
    """Last graded row before the gap."""
    again: int
    """First graded row after it."""
    before: int
    """Last graded row with a track up to `last`."""
    after: int | None
    """First graded row with a track from `again` on; None if there is none in time."""


def gaps(vehicle: pd.DataFrame, config: GradingConfig, longest_s: float) -> Iterator[Gap]:
    """Yield each occlusion of one vehicle, from its rows of `truth` in time order.

    An occlusion is a gap of at most `longest_s` in the vehicle's grading, with a visible fraction of at most
    `hidden_fraction_max`, in which the vehicle would have returns without occluders. The track before is the last one
    that followed the graded vehicle, the track after is the first one; both are at most `memory_s` from the gap. A gap
    without a track before is left out.
    """
    graded = vehicle["graded"].to_numpy()
    time = vehicle["time_s"].to_numpy()
    followed = np.flatnonzero(graded & (vehicle["track_id"].to_numpy() != NO_TRACK))
    dark = (vehicle["visible_fraction"] <= config.hidden_fraction_max) & (vehicle["hits_alone"] > 0)
    hidden = dark.to_numpy()
    for last, again in pairwise(np.flatnonzero(graded).tolist()):
        if time[again] - time[last] > longest_s or not hidden[last + 1 : again].any():
            continue
        before, after = followed[followed <= last], followed[followed >= again]
        if not len(before) or time[last] - time[before[-1]] > config.memory_s:
            continue
        in_time = len(after) and time[after[0]] - time[again] <= config.memory_s
        yield Gap(last, again, int(before[-1]), int(after[0]) if in_time else None)
