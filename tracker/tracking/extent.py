"""Vehicle size: memory of the seen extents, completed by priors of vehicle classes."""

from dataclasses import dataclass, field

import numpy as np

from tracker.arrays import Bools, Floats, Ints
from tracker.bounds import require_within


@dataclass(frozen=True, slots=True)
class TypicalSize:
    """Typical size of a vehicle class."""

    length_m: float
    """Length while too little of a side was visible to measure it [m]."""
    width_m: float
    """Minimum width [m]; widths vary less than the hidden part of a side."""
    rounding_m: float
    """Part of a side that the rounded far corner hides [m]."""

    def __post_init__(self) -> None:
        require_within(self, 0.0, 1e3, "length_m", "width_m", "rounding_m")


@dataclass(frozen=True, slots=True)
class ExtentConfig:
    """Memory of a vehicle's size, and priors for unseen sides."""

    small: TypicalSize = field(default_factory=lambda: TypicalSize(length_m=2.1, width_m=0.76, rounding_m=0.0))
    """Motorcycles, with rider: the mean label of nuScenes (Caesar et al. 2020)."""
    car: TypicalSize = field(default_factory=lambda: TypicalSize(length_m=4.6, width_m=1.8, rounding_m=0.3))
    """Cars, whose corners are rounded by 0.25 to 0.4 m in plan view: the mean length of nuScenes' labels, and a width
    between those of nuScenes, 1.95, and KITTI, 1.63 (Geiger et al. 2012)."""
    large: TypicalSize = field(default_factory=lambda: TypicalSize(length_m=6.7, width_m=2.46, rounding_m=0.1))
    """Trucks: the mean label of nuScenes. Buses are longer, which their visible length shows."""
    small_from_hits: int = 12
    """Minimum observations of a motorcycle: after these, a small seen extent is not a car that is mostly hidden."""
    small_length_max_m: float = 2.6
    """Maximum length of a motorcycle [m]."""
    small_width_max_m: float = 1.0
    """Maximum width of a motorcycle [m]."""
    large_length_min_m: float = 6.0
    """Minimum length of a truck or bus; cars are shorter [m]."""
    large_width_min_m: float = 2.25
    """Minimum width of a truck or bus; cars are narrower [m]."""
    length_seen_share: float = 0.75
    """A seen length of at least this share of the typical length is the length of the vehicle."""
    sights_min: int = 4
    """A length seen from end to end this often is the length of the vehicle."""
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
    """Minimum length of a car without its rounded corners [m]."""
    grown_min_m: float = 0.5
    """A side that grows by more than this was truncated before [m]: two beams at either end."""
    known_share: float = 0.8
    """A side is known to exist completely if this share of it was seen."""


def remember(seen: Floats, observed: Floats, whole: Bools, whole_views: Ints, config: ExtentConfig) -> Floats:
    """Return the remembered extents (2,) along and across the heading after one more observation (2,) [m].

    A vehicle is at least as large as its visible part. A side that is not `whole` (2,) may be longer, so a short
    observation of it has no effect. `whole_views` (2,) counts earlier observations of either side as a whole.
    """
    gain = np.maximum(config.growth / (1 + whole_views), config.settled)
    gain = np.where(observed > seen, gain, np.where(seen_whole(observed, whole, config), 0.5 * gain, 0.0))
    return np.asarray(seen + gain * (observed - seen))


def seen_whole(observed: Floats, whole: Bools, config: ExtentConfig) -> Bools:
    """(2,) mask of sides, observed over (2,) [m], that were seen from end to end: not facing away and not truncated."""
    return np.asarray(whole & (observed > config.face_min_m))


def too_large(seen: Floats, config: ExtentConfig) -> bool:
    """Return True if the seen extents (2,) [m] are larger than any vehicle."""
    return bool(seen.min() > config.width_max_m)


def long(seen: Floats, config: ExtentConfig) -> bool:
    """Return True if the seen extents (2,) [m] exceed the length of a car."""
    return bool(seen.max() > config.large_length_min_m)


def classify(seen: Floats, whole_views: Ints, hits: int, config: ExtentConfig) -> TypicalSize:
    """Return the class of a vehicle with seen extents (2,) along and across the heading [m].

    `whole_views` (2,) counts observations of either side as a whole; `hits` counts observations since the direction of
    motion confirmed the heading: without it, the rear of a car may be taken for the side of a motorcycle.
    """
    length, width = seen
    if length > config.large_length_min_m or (width > config.large_width_min_m and whole_views[1] > 0):
        return config.large
    narrow = length < config.small_length_max_m and width < config.small_width_max_m
    seen_often = min(hits, int(whole_views.max())) >= config.small_from_hits
    return config.small if narrow and seen_often else config.car


def complete(seen: Floats, whole_views: Ints, usual: TypicalSize, config: ExtentConfig) -> Floats:
    """(2,) length and width [m]: the seen extents, or the typical ones where too little was seen.

    `whole_views` (2,) counts observations of either side as a whole.
    """
    enough = seen[0] >= config.length_seen_share * usual.length_m
    enough |= seen[0] > config.length_min_m and whole_views[0] >= config.sights_min
    length = seen[0] + usual.rounding_m if enough else usual.length_m
    return np.array([length, max(seen[1], usual.width_m)])


def known(seen: Floats, size: Floats, config: ExtentConfig) -> Floats:
    """(2,) part of each side that is known to exist [m]: all of `size` once nearly all was seen, else the seen part."""
    return np.where(seen >= config.known_share * size, size, seen)
