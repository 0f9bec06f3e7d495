"""Compared metrics, and their computation from sums over vehicles.

The list has a few metrics of each stage, so that a degradation of any stage shows. Every further metric would lower the
statistical power of the comparison. Times are not compared, because they depend on the machine. Metrics without
vehicles, like the safety of a controlled ego, are not compared either; expectations cover them.
"""

from dataclasses import dataclass

import numpy as np

from luxloop.arrays import Floats
from luxloop.scenarios.compare.vehicle_sums import COLUMNS, FURTHER
from luxloop.scenarios.grading import tracking_scores
from luxloop.scenarios.grading.tracking_scores import ALPHAS
from luxloop.scenarios.metrics.definition import Better, Relevance
from luxloop.scenarios.metrics.definitions import find_metric

_INDEX = {name: index for index, name in enumerate(COLUMNS)}


SHARE = Relevance(absolute=0.005, full=1.0)
"""For shares and scores between 0 and 1: half a percent of the observations."""
RARE = Relevance(absolute=0.0005, full=0.1)
"""For rare events: one more in 2000 observations, which are 160 s of one vehicle in view."""
ANGLE = Relevance(absolute=0.001, relative=0.01)
"""For mean errors [deg]: one percent, but at least 0.001 deg."""
LENGTH = Relevance(absolute=0.0002, relative=0.01)
"""For mean errors [m]: one percent, but at least 0.2 mm."""


@dataclass(frozen=True, slots=True)
class ComparedMetric:
    """A metric as the ratio of two sums over vehicles, `part` over `whole`."""

    name: str
    relevance: Relevance
    whole: tuple[str, ...]
    """Columns that add up to the denominator; the metric has no value if it is 0."""
    part: tuple[str, ...] = ()
    """Columns that add up to the numerator; a leading minus subtracts. Empty for HOTA, which is not a ratio."""

    @property
    def unit(self) -> str:
        """Unit of the metric."""
        return find_metric(self.name).unit

    @property
    def better(self) -> Better:
        """Direction of improvement."""
        return find_metric(self.name).definition.better

    @property
    def largest_difference(self) -> float:
        """Largest possible difference between two values, in the metric's unit; infinite without a limit."""
        smallest, largest = find_metric(self.name).definition.range
        return largest - smallest

    def observations(self, sums: Floats) -> Floats:
        """Return the denominators (R,) for R sets of sums (R, len(COLUMNS))."""
        return _total(sums, self.whole)

    def loss(self, difference: float) -> float:
        """Return a difference with the sign of a loss: positive if HEAD is worse."""
        return -difference if self.better == "more" else difference

    def value(self, sums: Floats) -> Floats:
        """Return the values (R,) for R sets of sums (R, len(COLUMNS)); NaN without observations."""
        whole = self.observations(sums)
        safe = np.where(whole > 0.0, whole, np.nan)
        return _total(sums, self.part) / safe if self.part else _hota(sums) + 0.0 * safe


def values(sums: Floats, metrics: tuple[ComparedMetric, ...]) -> Floats:
    """(R, M) values of the metrics for R sets of sums (R, len(COLUMNS))."""
    return np.column_stack([metric.value(sums) for metric in metrics])


def _total(sums: Floats, names: tuple[str, ...]) -> Floats:
    total = np.zeros(len(sums))
    for name in names:
        total += -sums[:, _INDEX[name[1:]]] if name.startswith("-") else sums[:, _INDEX[name]]
    return total


def _hota(sums: Floats) -> Floats:
    matched, associated = np.split(sums[:, -2 * len(ALPHAS) :], 2, axis=1)
    return tracking_scores.hota(_total(sums, ("observations", "reported")), matched, associated)


def _mean(name: str, relevance: Relevance, part: str, whole: str) -> ComparedMetric:
    return ComparedMetric(name, relevance, (whole,), (part,))


def _further(name: str) -> ComparedMetric:
    relevance = find_metric(name).definition.compared
    assert relevance is not None
    return _mean(name, relevance, f"{name} part", f"{name} whole")


COMPARED_METRICS = (
    ComparedMetric("track.hota", SHARE, ("observations", "reported")),
    ComparedMetric("track.idf1", SHARE, ("observations", "reported"), ("identified", "identified")),
    ComparedMetric(
        "track.mota", SHARE, ("observations",), ("hits", "hits", "-reported", "-switches")
    ),  # 1 - (misses + false + switches) / observations
    ComparedMetric("track.missed_share", SHARE, ("observations",), ("observations", "-hits")),
    ComparedMetric("track.false_share", SHARE, ("observations",), ("reported", "-hits")),
    ComparedMetric("track.id_switch_rate", RARE, ("observations",), ("switches",)),
    ComparedMetric("track.occlusion_survival", SHARE, ("occlusions",), ("survived",)),
    _mean("track.heading_flip_rate", SHARE, "flipped", "moving"),
    ComparedMetric("track.heading_unflipped_mean_deg", ANGLE, ("moving", "-flipped"), ("heading_deg",)),
    _mean("mma.x_abs_mean_m{target=standing}", LENGTH, "standing_x_m", "standing"),
    _mean("mma.y_abs_mean_m{target=standing}", LENGTH, "standing_y_m", "standing"),
    _mean("mma.x_abs_mean_m{target=moving}", LENGTH, "moving_x_m", "moving"),
    _mean("mma.y_abs_mean_m{target=moving}", LENGTH, "moving_y_m", "moving"),
    ComparedMetric("mma.mode_accuracy", SHARE, ("standing", "moving"), ("right_mode",)),
    _mean("fit.heading_abs_mean_deg", ANGLE, "fit_heading_deg", "fitted"),
    _mean("fit.position_abs_mean_m", LENGTH, "fit_position_m", "fitted"),
    ComparedMetric("fit.coverage", SHARE, ("segmented",), ("fitted",)),
    _mean("segmentation.over_rate", SHARE, "split", "segmented"),
    _mean("segmentation.under_rate", SHARE, "merged", "segments"),
    _mean("segmentation.missed_rate", SHARE, "in_no_segment", "segmented"),
    *map(_further, FURTHER),
)
"""Main metrics of each stage, and those that their definitions add; unit, direction and range are theirs."""
