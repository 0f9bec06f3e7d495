"""Visible extents of a vehicle: memory of what was seen of its sides."""

from dataclasses import dataclass

import numpy as np

from luxloop.tracker.arrays import Floats
from luxloop.tracker.bounds import require_within


@dataclass(frozen=True, slots=True)
class ExtentConfig:
    """Memory of a vehicle's seen extents, and the evidence of its views for its size."""

    view_correlation: float = 0.2
    """Correlation of the views of a side: many equal views have the evidence of five."""
    forgetting: float = 0.04
    """Share of the earlier evidence that a view of the whole side replaces: two seconds at 12.5 scans a second."""
    truncated_probability: float = 0.3
    """Probability that a side that seems whole is truncated: thin occluders and lost beams are not detected."""
    merged_probability: float = 0.05
    """Probability that a view contains more than the vehicle: a neighbour, or a doubled contour."""
    hidden_length_m: float = 0.27
    """Part of a length that rounded corners hide from a view of the whole side [m]: 0.2 to 0.4 on cars."""
    hidden_width_m: float = 0.15
    """Part of a width that rounded corners hide from a view of the whole side [m]: 0.1 to 0.2 on cars."""
    large_length_min_m: float = 6.0
    """Minimum length of a truck or bus; cars are shorter [m]."""
    growth: float = 0.5
    """Initial gain of the size filter for a side that is longer than remembered."""
    settled: float = 0.05
    """Final gain, after many views of the whole side: the gain decreases with each, so that a box merged with its
    neighbour has little effect. A whole side that looks shorter has half the gain, because ends have few points."""
    face_min_m: float = 0.6
    """A side with a smaller visible extent may face away [m]; corners are rounded by 0.25 to 0.4."""
    width_max_m: float = 2.8
    """Maximum width of a vehicle [m]: a truck measures 2.55."""
    length_min_m: float = 3.0
    """Minimum length of a side that shows the axis of a vehicle [m]; vehicles are narrower."""
    grown_min_m: float = 0.5
    """A side that grows by more than this was truncated before [m]: two beams at either end."""
    known_share: float = 0.8
    """A side is known to exist completely if this share of it was seen."""

    def __post_init__(self) -> None:
        require_within(self, 0.0, 1.0, "view_correlation", "truncated_probability")
        require_within(self, 1e-3, 1.0, "forgetting")
        require_within(self, 1e-9, 1.0, "merged_probability")
        require_within(self, 0.0, 1e3, "hidden_length_m", "hidden_width_m")


def too_large(seen: Floats, config: ExtentConfig) -> bool:
    """Return True if the seen extents (2,) [m] are larger than any vehicle."""
    return bool(min(seen.tolist()) > config.width_max_m)


def long(seen: Floats, config: ExtentConfig) -> bool:
    """Return True if the seen extents (2,) [m] exceed the length of a car."""
    return bool(max(seen.tolist()) > config.large_length_min_m)


def known(seen: Floats, size: Floats, config: ExtentConfig) -> Floats:
    """(2,) part of each side that is known to exist [m]: all of `size` once nearly all was seen, else the seen part."""
    sides = zip(seen.tolist(), size.tolist(), strict=True)
    return np.array([whole if part >= config.known_share * whole else part for part, whole in sides])


def likely(seen: Floats, size: Floats, std: Floats) -> Floats:
    """Part of each side (..., 2) that probably exists [m], with the standard deviations of `size`."""
    return np.asarray(np.maximum(np.minimum(seen, size), size - std))
