"""Sides of vehicles: likelihood that one of two visible sides is the length and the other one the width."""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

from tracker.arrays import Bools, Floats
from tracker.tracking import face_depths


class VehicleClass(NamedTuple):
    """Range of sizes of a vehicle class, with a uniform distribution."""

    share: float
    """Share of all vehicles."""
    length_m: tuple[float, float]
    """Shortest and longest [m]."""
    width_m: tuple[float, float]
    """Narrowest and widest without mirrors [m]."""
    face_density: Callable[[float], float] = face_depths.of_car
    """Density of the depth of a single face [1/m]."""


CLASSES = (
    VehicleClass(0.70, (3.4, 5.3), (1.5, 2.15)),
    VehicleClass(0.25, (5.1, 18.9), (2.1, 2.75), face_density=face_depths.of_lorry),
    VehicleClass(0.05, (1.8, 2.6), (0.5, 1.1)),
)
"""Cars and vans, lorries and buses up to the limits of Directive 96/53/EC (18.75 m and 2.6 m), motorcycles; all ranges
are wider by 0.1 to 0.15 m, the errors of visible extents. The shares are rough."""

PAIR = VehicleClass(0.25, (7.0, 12.0), (1.5, 2.15), face_density=face_depths.of_lorry)
"""Two cars in a row that form one segment: as long as a lorry, but no vehicle, and about as frequent."""

CAR_LENGTH_MAX_M = 5.3
"""Length of a car at most [m]: a shorter piece of a pair is one of both cars."""

ROUNDING_M = 0.4
"""Part of a side that rounded corners hide at most, both ends together [m]."""

SINGLE_FACE_SHARE = 0.4
"""Share of views of vehicles with a single visible face."""

BACKGROUND_LENGTH_M = (0.5, 20.0)
"""Lengths of background segments [m]; longer ones are removed as walls."""

OUTLIER_DENSITY = 1e-3
"""Density of sides of any other extent [1/m], which limits the evidence of one view."""


Side = tuple[float, float]
"""Visible extent [m] of a side, and the probability that it is truncated."""


def length_log_odds(size: Floats, whole: Bools, visible_min_m: float, truncated_probability: float) -> float:
    """Return the log-odds that the first of two sides is the length of a vehicle, and the second one its width.

    The sides come from a mixture of `CLASSES`. A whole side shows its extent but for `ROUNDING_M`. A truncated side
    shows a piece of any shorter extent, all equally likely.

    Parameters
    ----------
    size
        (2,) visible extents [m].
    whole
        (2,) mask of sides that are truncated at neither end.
    visible_min_m
        A shorter side may face away, and contains no information [m].
    truncated_probability
        Probability that a side that seems whole is truncated by something that was not detected.
    """
    sides = _with_truncation(size, whole, truncated_probability)

    def density(sides: Sequence[Side]) -> float:
        return sum(
            vehicle.share * _side_density(sides[0], vehicle.length_m, visible_min_m)
            * _side_density(sides[1], vehicle.width_m, visible_min_m)
            for vehicle in CLASSES
        )  # fmt: skip

    return math.log(density(sides) / density(sides[::-1]))


def vehicle_log_odds(size: Floats, whole: Bools, truncated_probability: float) -> float:
    """Return the log-odds of a view of two sides (2,) [m] for a vehicle, against a piece of a building or a wall.

    A vehicle shows its length and its width, or a single face, which is one of both. Background has any length on a
    logarithmic scale and the depth of a wall, or is a `PAIR`.

    Parameters
    ----------
    size, whole, truncated_probability
        As for `length_log_odds`.
    """
    sides = sorted(_with_truncation(size, whole, truncated_probability), reverse=True)
    longer, shorter = sides[0][0], sides[1][0]

    def density(kind: VehicleClass) -> float:
        alone = 0.5 * SINGLE_FACE_SHARE * kind.face_density(shorter)
        return kind.share * sum(
            _side_density(sides[0], one, 0.0)
            * (alone + (1.0 - SINGLE_FACE_SHARE) * _side_density(sides[1], other, 0.0))
            for one, other in ((kind.length_m, kind.width_m), (kind.width_m, kind.length_m))
        )  # fmt: skip

    low, high = BACKGROUND_LENGTH_M
    background = face_depths.of_background(shorter) / (math.log(high / low) * max(longer, low))
    if longer > CAR_LENGTH_MAX_M:
        background += density(PAIR)
    return math.log(sum(map(density, CLASSES)) / background)


def correlated_sum(total: float, views: int, correlation: float) -> float:
    """Return the evidence of a `total` of log-odds over views of one object, whose errors are correlated.

    The evidence of n equal views with correlation r is that of n / (1 + (n - 1) r).
    """
    return total / (1.0 + correlation * max(views - 1, 0))


def _with_truncation(size: Floats, whole: Bools, truncated_probability: float) -> list[Side]:
    """Return visible extents [m] and probabilities of truncation of two sides."""
    pairs = zip(size.tolist(), whole.tolist(), strict=True)
    return [(extent, truncated_probability if seen else 1.0) for extent, seen in pairs]


def _side_density(side: Side, limits: tuple[float, float], visible_min_m: float) -> float:
    """Return the density of a side from a range of lengths [m], or 1 for one that may face away."""
    extent, truncated = side
    return _density(extent, truncated, *limits) + OUTLIER_DENSITY if extent > visible_min_m else 1.0


def _density(extent: float, truncated: float, low: float, high: float) -> float:
    """Return the density [1/m] of a visible extent [m] of a side from a range of lengths [m].

    The side is `truncated` with this probability.
    """
    whole = max(min(high, extent + ROUNDING_M) - max(low, extent), 0.0) / ROUNDING_M
    piece = math.log(high / max(low, extent)) if extent < high else 0.0
    return ((1.0 - truncated) * whole + truncated * piece) / (high - low)
