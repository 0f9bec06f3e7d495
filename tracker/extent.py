"""How big a vehicle is: what was seen of each side, completed by what vehicles of that size measure."""

from dataclasses import dataclass

import numpy as np

from tracker.records import Floats


@dataclass(frozen=True, slots=True)
class ExtentConfig:
    """Memory of a vehicle's size and priors for the sides not seen."""

    car_length_m: float = 4.7
    """Usual length of a car [m]."""
    car_width_m: float = 1.8
    """Least width of a car [m]; unlike its length, a car's width varies by no more than what is hidden of it."""
    large_length_m: float = 8.0
    """The same for trucks and buses [m]."""
    large_width_m: float = 2.5
    large_from_length_m: float = 6.0
    """Longer than this is no car."""
    large_from_width_m: float = 2.25
    """Wider than this is no car."""
    length_min_m: float = 3.5
    """A side seen this long is taken for the whole length [m]; no car is shorter."""
    car_rounding_m: float = 0.3
    """What the rounded far corner hides of a car's side [m]: corners are rounded by 0.25 to 0.4 m in plan view."""
    large_rounding_m: float = 0.1
    """The same for trucks and buses [m]."""
    growth: float = 0.3
    """Share of the difference taken over when a side is seen longer than remembered."""
    decay: float = 0.01
    """The same when it is seen nearly as long; keeps single long outliers from staying for good."""
    nearly: float = 0.8
    """A side seen at this share of its remembered length counts as seen in full."""


def remember(seen: Floats, observed: Floats, config: ExtentConfig) -> Floats:
    """(2,) remembered extents along and across the heading after one more observation (2,) [m].

    A vehicle is never smaller than what is seen of it, while a short sight may be an occlusion:
    long sights pull fast, nearly full ones slowly, short ones not at all.
    """
    pull = np.where(observed > seen, config.growth, np.where(observed > config.nearly * seen, config.decay, 0.0))
    return np.asarray(seen + pull * (observed - seen))


def complete(seen: Floats, config: ExtentConfig) -> Floats:
    """(2,) length and width [m]: what was seen, and the usual for its class where too little was seen to tell."""
    large = seen[0] > config.large_from_length_m or seen[1] > config.large_from_width_m
    length, width = (
        (config.large_length_m, config.large_width_m) if large else (config.car_length_m, config.car_width_m)
    )
    if seen[0] >= config.length_min_m:
        length = seen[0] + (config.large_rounding_m if large else config.car_rounding_m)
    return np.array([length, max(seen[1], width)])


def known(seen: Floats, config: ExtentConfig) -> Floats:
    """(2,) how much of each side is known to be there [m]: all of it once nearly all was seen, else what was seen."""
    size = complete(seen, config)
    return np.where(seen >= config.nearly * size, size, seen)
