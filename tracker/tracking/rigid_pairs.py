"""Pieces of one vehicle at any speed: the gap between them stays the same while their speed changes.

A driver keeps a headway in time. The gap to the vehicle in front therefore grows with speed, and a start from rest
opens it at once. The gap between a tractor and its trailer does not change.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from luxloop.tracker.merging import MergeConfig, Pieces, gap, may_be_one


@dataclass(slots=True)
class PairHistory:
    """Extremes of gap and speed since the gap last changed."""

    gap_m: tuple[float, float]
    """Smallest and largest gap between the pieces [m]."""
    speed_mps: tuple[float, float]
    """Lowest and highest speed [m/s]."""


class RigidPairs:
    """Histories of the pairs of tracks that may be pieces of one vehicle."""

    def __init__(self, config: MergeConfig) -> None:
        self._config = config
        self._history: dict[tuple[int, int], PairHistory] = {}

    def observe(self, ids: Sequence[int], pieces: Pieces) -> None:
        """Add one frame of the tracks `ids`, in the order of `pieces`; forget pairs that are not seen together."""
        history: dict[tuple[int, int], PairHistory] = {}
        speed = [math.hypot(x, y) for x, y in pieces.velocity.tolist()]
        for a, b in may_be_one(pieces, self._config):
            key = (min(ids[a], ids[b]), max(ids[a], ids[b]))
            mean = 0.5 * (speed[a] + speed[b])
            history[key] = self._extended(self._history.get(key), gap(pieces, a, b), mean)
        self._history = history

    def rigid(self, a: int, b: int) -> bool:
        """Return True if two tracks, by id, changed their speed together and kept their gap."""
        pair = self._history.get((min(a, b), max(a, b)))
        if pair is None:
            return False
        change = pair.speed_mps[1] - pair.speed_mps[0]
        return change >= self._config.speed_change_min_mps

    def _extended(self, pair: PairHistory | None, gap_m: float, speed_mps: float) -> PairHistory:
        """Return the history with one more frame, or a new one if the gap has changed."""
        if pair is not None:
            gaps = min(pair.gap_m[0], gap_m), max(pair.gap_m[1], gap_m)
            if gaps[1] - gaps[0] <= self._config.gap_change_max_m:
                return PairHistory(gaps, (min(pair.speed_mps[0], speed_mps), max(pair.speed_mps[1], speed_mps)))
        return PairHistory((gap_m, gap_m), (speed_mps, speed_mps))
