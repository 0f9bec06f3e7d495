"""The metrics that are compared, and how each comes from sums over vehicles.

A few of each stage, so that a change that hurts shows in one of them at least; every further one makes chance harder to
tell from change. Times are left out: they are the machine's. So is what has no vehicle to it, as how a controlled ego
drives: of that, the expectations tell.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from scenarios.arrays import Floats
from scenarios.compare.sums import COLUMNS
from scenarios.compare.vehicle_sums import ALPHAS

_AT = {name: place for place, name in enumerate(COLUMNS)}


@dataclass(frozen=True, slots=True)
class Relevance:
    """From which difference on anybody would care; the larger of both counts."""

    absolute: float
    """In the metric's unit."""
    relative: float = 0.0
    """Share of BASE's value."""

    def margin(self, base: float) -> float:
        """The least difference from this value that is relevant."""
        return max(self.absolute, self.relative * abs(base))


SHARE = Relevance(absolute=0.005)
"""Of a share or score between 0 and 1: half a percent of what was to be seen."""
RARE = Relevance(absolute=0.0005)
"""Of what happens now and then: one more in 2000 observations, 160 s of one vehicle in view."""
ANGLE = Relevance(absolute=0.001, relative=0.01)
"""Of a mean error [deg]: a hundredth of it, if that is not next to nothing."""
LENGTH = Relevance(absolute=0.0002, relative=0.01)
"""Of a mean error [m], likewise."""


@dataclass(frozen=True, slots=True)
class ComparedMetric:
    """One metric: what vehicles add to `part`, over what they add to `whole`."""

    name: str
    unit: str
    better: Literal["more", "less"]
    relevance: Relevance
    whole: tuple[str, ...]
    """Columns that are added up; there is no value where they are 0."""
    part: tuple[str, ...] = ()
    """Likewise; those with a minus are taken away. HOTA, which is no ratio, has none."""

    def value(self, sums: Floats) -> Floats:
        """(R,) values for R sets of sums (R, len(COLUMNS)); NaN where there was nothing to see."""
        whole = _total(sums, self.whole)
        safe = np.where(whole > 0.0, whole, np.nan)
        return _total(sums, self.part) / safe if self.part else _hota(sums) + 0.0 * safe


def _total(sums: Floats, names: tuple[str, ...]) -> Floats:
    total = np.zeros(len(sums))
    for name in names:
        total += -sums[:, _AT[name[1:]]] if name.startswith("-") else sums[:, _AT[name]]
    return total


def _hota(sums: Floats) -> Floats:
    """Geometric mean of detection and association, averaged over overlaps (Luiten et al. 2021).

    Pooled over runs as trackeval combines sequences.
    """
    detections = _total(sums, ("observations", "reported"))[:, None]
    matched, associated = np.split(sums[:, -2 * len(ALPHAS) :], 2, axis=1)
    # DetA = TP / (TP + FN + FP), AssA = sum of A / TP: their product has no TP to divide by.
    hota: Floats = np.sqrt(associated / np.maximum(detections - matched, 1.0)).mean(axis=1)
    return hota


def _mean(name: str, unit: str, relevance: Relevance, part: str, whole: str) -> ComparedMetric:
    return ComparedMetric(name, unit, "less", relevance, (whole,), (part,))


COMPARED_METRICS = (
    ComparedMetric("track.hota", "1", "more", SHARE, ("observations", "reported")),
    ComparedMetric("track.idf1", "1", "more", SHARE, ("observations", "reported"), ("identified", "identified")),
    ComparedMetric(
        "track.mota", "1", "more", SHARE, ("observations",), ("hits", "hits", "-reported", "-switches")
    ),  # 1 - (misses + false + switches) / observations
    ComparedMetric("track.missed_rate", "1", "less", SHARE, ("observations",), ("observations", "-hits")),
    ComparedMetric("track.false_rate", "1", "less", SHARE, ("observations",), ("reported", "-hits")),
    ComparedMetric("track.id_switch_rate", "1", "less", RARE, ("observations",), ("switches",)),
    ComparedMetric("track.occlusion_survival", "1", "more", SHARE, ("occlusions",), ("survived",)),
    _mean("track.heading_flip_rate", "1", SHARE, "flipped", "moving"),
    ComparedMetric("track.heading_unflipped_mean_deg", "deg", "less", ANGLE, ("moving", "-flipped"), ("heading_deg",)),
    _mean("mma.mma.stationary_target.x_abs_mean_m", "m", LENGTH, "standing_x_m", "standing"),
    _mean("mma.mma.stationary_target.y_abs_mean_m", "m", LENGTH, "standing_y_m", "standing"),
    _mean("mma.mma.moving_target.x_abs_mean_m", "m", LENGTH, "moving_x_m", "moving"),
    _mean("mma.mma.moving_target.y_abs_mean_m", "m", LENGTH, "moving_y_m", "moving"),
    ComparedMetric("mma.mode_accuracy", "1", "more", SHARE, ("standing", "moving"), ("right_mode",)),
    _mean("fit.best.heading_abs_mean_deg", "deg", ANGLE, "fit_heading_deg", "fitted"),
    _mean("fit.best.position_abs_mean_m", "m", LENGTH, "fit_position_m", "fitted"),
    ComparedMetric("fit.best.coverage", "1", "more", SHARE, ("segmented",), ("fitted",)),
    _mean("segmentation.over_rate", "1", SHARE, "split", "segmented"),
    _mean("segmentation.under_rate", "1", SHARE, "merged", "segments"),
    _mean("segmentation.missed_rate", "1", SHARE, "in_no_segment", "segmented"),
)
"""Named as in a result, except

- the rates of tracking: counts of a result (`track.missed`, `track.false`, `track.id_switches`) over its observations;
- `track.heading_unflipped_mean_deg`: `track.heading_abs_mean_deg` of the headings that are no more than 90 degrees off.
  A few that are turned by 180 would drown it; they are counted by `track.heading_flip_rate`."""
