"""How big a vehicle is: what was seen of each side, completed by what vehicles of that size measure."""

from dataclasses import dataclass, field

import numpy as np

from tracker.arrays import Bools, Floats, Ints

ONE_SIDE, CORNER, FULL_VIEW = 1, 2, 4
"""What a sight weighs as evidence for a vehicle: walls are bare sides, some turn a corner, few measure as a car's."""


@dataclass(frozen=True, slots=True)
class TypicalSize:
    """A class of vehicles."""

    length_m: float
    """Length given while too little of a side was seen to tell [m]."""
    width_m: float
    """Least width [m]; it varies less than what is hidden of it."""
    rounding_m: float
    """What the rounded far corner hides of a side [m]."""


@dataclass(frozen=True, slots=True)
class ExtentConfig:
    """Memory of a vehicle's size and priors for the sides not seen."""

    small: TypicalSize = field(default_factory=lambda: TypicalSize(length_m=2.2, width_m=0.8, rounding_m=0.0))
    """Motorcycles, with rider."""
    car: TypicalSize = field(default_factory=lambda: TypicalSize(length_m=4.7, width_m=1.8, rounding_m=0.3))
    """Cars, whose corners are rounded by 0.25 to 0.4 m in plan view."""
    large: TypicalSize = field(default_factory=lambda: TypicalSize(length_m=8.0, width_m=2.5, rounding_m=0.1))
    """Trucks and buses."""
    small_from_hits: int = 12
    """No car hides all but a motorcycle's share of itself through this many observations."""
    small_length_max_m: float = 2.6
    """Longer is no motorcycle [m]."""
    small_width_max_m: float = 1.0
    """Wider is no motorcycle [m]."""
    large_length_min_m: float = 6.0
    """Longer is no car [m]."""
    large_width_min_m: float = 2.25
    """Wider is no car [m]."""
    length_seen_share: float = 0.75
    """A side seen at this share of the usual length is taken for the whole length."""
    sights_min: int = 4
    """A length seen as a whole this often is the length."""
    growth: float = 0.5
    """Share of the difference taken over when a side is seen longer than remembered, at first ..."""
    settled: float = 0.05
    """... and after many sights of the whole side, each of which counts the less: one merged with its neighbour does
    no harm then. Ends of few points fade: a whole side that looks shorter counts half as much."""
    face_min_m: float = 0.6
    """A side of which less is seen may be one that is turned away [m]; corners are rounded by 0.25 to 0.4."""
    rounding_min_m: float = 0.25
    """A face this deep turns a corner [m]: those of cars are rounded by 0.25 to 0.4."""
    width_min_m: float = 1.4
    """Least width of a car, without its rounded corners [m]; motorcycles are known by their motion."""
    width_max_m: float = 2.8
    """No vehicle is wider [m]: a truck measures 2.55."""
    length_min_m: float = 3.0
    """Least length of a car, without its rounded corners [m]."""
    full_min_m: float = 1.2
    """Two sides both seen this far are a full view [m]: no niche, no kerb and no rounded corner is as deep."""
    grown_min_m: float = 0.5
    """A side that gets longer than it was by more was not seen as a whole before [m]: two beams at either end."""
    known_share: float = 0.8
    """A side of which this share was seen is known to be there as a whole."""


def remember(seen: Floats, observed: Floats, whole: Bools, sights: Ints, config: ExtentConfig) -> Floats:
    """(2,) remembered extents along and across the heading after one more observation (2,) [m].

    A vehicle is never smaller than what is seen of it, while it may be larger if it is not seen as a `whole` (2,):
    then a short sight says nothing. `sights` (2,) is how often either side was seen as a whole before.
    """
    gain = np.maximum(config.growth / (1 + sights), config.settled)
    gain = np.where(observed > seen, gain, np.where(seen_whole(observed, whole, config), 0.5 * gain, 0.0))
    return np.asarray(seen + gain * (observed - seen))


def seen_whole(observed: Floats, whole: Bools, config: ExtentConfig) -> Bools:
    """(2,) whether sides seen over (2,) [m] were seen as a whole: not turned away, and cut off at neither end."""
    return np.asarray(whole & (observed > config.face_min_m))


def too_large(seen: Floats, config: ExtentConfig) -> bool:
    """Whether more was seen of it, (2,) [m], than there is of any vehicle."""
    return bool(seen.min() > config.width_max_m)


def is_vehicle(observed: Floats, whole: Bools, largest: Floats, config: ExtentConfig) -> bool:
    """Whether sides (2,) [m], of which those that are `whole` (2,) end where they seem to, are those of a vehicle.

    Pieces of walls between things that hide the rest have any length. A whole side has to be as wide or as long as a
    car, or a side has to turn a corner and be no longer than a car's; a wall is flat within 0.15. Where more than a
    car's length was ever seen, `largest` (2,), only a truck's width tells a truck from the corner of a house.
    """
    if largest.max() > config.large_length_min_m:
        return bool(np.any(whole & (observed > config.large_width_min_m) & (observed < config.width_max_m)))
    if observed.min() > config.rounding_min_m and observed.max() > config.width_min_m:
        return bool(observed.min() < config.width_max_m)
    wide = (observed > config.width_min_m) & (observed < config.width_max_m)
    return bool(np.any(whole & (wide | (observed > config.length_min_m))))


def is_piece(observed: Floats, whole: Bools, config: ExtentConfig) -> bool:
    """Whether what is seen, (2,) [m], might be a piece of a wall: one side alone, or no side from end to end."""
    return bool(observed.min() <= config.rounding_min_m or not whole.any())


def evidence(observed: Floats, whole: Bools, largest: Floats, config: ExtentConfig) -> int:
    """How much a sight of sides (2,) [m] says for a vehicle.

    In full view are two sides seen for good, one of them from end to end. `largest` (2,) is as in `is_vehicle`.
    """
    if not is_vehicle(observed, whole, largest, config):
        return 0
    if largest.max() > config.large_length_min_m:
        return CORNER
    if observed.min() <= config.rounding_min_m:
        return ONE_SIDE
    return FULL_VIEW if whole.any() and observed.min() > config.full_min_m else CORNER


def long(seen: Floats, config: ExtentConfig) -> bool:
    """Whether more was seen of it, (2,) [m], than a car is long."""
    return bool(seen.max() > config.large_length_min_m)


def car_sized(seen: Floats, config: ExtentConfig) -> bool:
    """Whether no more was seen, (2,) [m], than there is of a car."""
    return bool(seen.max() <= config.large_length_min_m and seen.min() <= config.large_width_min_m)


def classify(seen: Floats, sights: Ints, hits: int, config: ExtentConfig) -> TypicalSize:
    """Class of a vehicle of which (2,) was seen along and across the heading [m].

    `sights` (2,) is how often either side was seen as a whole, `hits` how often the vehicle was seen since its course
    told its front from its side: the rear of a car is as broad as a motorcycle is long.
    """
    length, width = seen
    if length > config.large_length_min_m or (width > config.large_width_min_m and sights[1] > 0):
        return config.large
    narrow = length < config.small_length_max_m and width < config.small_width_max_m
    return config.small if narrow and hits >= config.small_from_hits else config.car


def complete(seen: Floats, sights: Ints, usual: TypicalSize, config: ExtentConfig) -> Floats:
    """(2,) length and width [m]: what was seen, and the usual where too little was seen to tell.

    `sights` (2,) is how often either side was seen as a whole.
    """
    enough = seen[0] >= config.length_seen_share * usual.length_m
    enough |= seen[0] > config.length_min_m and sights[0] >= config.sights_min
    length = seen[0] + usual.rounding_m if enough else usual.length_m
    return np.array([length, max(seen[1], usual.width_m)])


def known(seen: Floats, size: Floats, config: ExtentConfig) -> Floats:
    """(2,) how much of each side is known to be there [m]: all of `size` once nearly all was seen, else what was."""
    return np.where(seen >= config.known_share * size, size, seen)
