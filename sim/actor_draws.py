"""Random draws of an actor, keyed by its name, so that another actor's arrival changes none: its paint, and its size.

A simulator's default sizes make all cars alike and longer than most: SUMO's default car is 5.0 m x 1.8 m x 1.5 m,
highway-env's 5.0 m x 2.0 m. A body of exactly a default size gets a random size of its class. It is never longer or
wider than the default, which is the space that the simulator keeps clear. The height may be larger, since neither
simulator considers heights in collisions. The ranges are engineering estimates.
"""

from enum import IntEnum
from hashlib import blake2b

import numpy as np

from luxloop.sim.world import Kind

_WORD = 2**64


class Stream(IntEnum):
    """Purpose of an actor's draws. Each has numbers of its own: add new ones at the end."""

    PAINT = 1
    START = 2
    """Jitter of a scripted start."""
    PROPORTIONS = 3
    """Proportions of the body, drawn by the sensor model."""
    SIZE = 4
    """Size in place of a simulator's default size."""


def actor_key(name: str) -> int:
    """Return the key of a name, from 0 to 2^64 - 1: the first 8 bytes of its BLAKE2b digest (RFC 7693), little-endian.

    Equal in every run and process, unlike `hash`. By the birthday bound, two of 10 000 names have the same key with a
    probability of 3e-12.
    """
    return int.from_bytes(blake2b(name.encode(), digest_size=8).digest(), "little")


def actor_rng(seed: int, name: str, stream: Stream) -> np.random.Generator:
    """Return the random generator of one actor and purpose: Philox, keyed by (seed, name), `stream` in its counter.

    The seed is taken modulo 2^64.
    """
    key = np.array([seed % _WORD, actor_key(name)], dtype=np.uint64)
    return np.random.Generator(np.random.Philox(key=key, counter=[0, 0, 0, int(stream)]))


CAR_SHADES = (
    # share, lowest, highest diffuse reflectivity
    (0.25, 0.01, 0.03),
    (0.25, 0.03, 0.075),
    (0.25, 0.075, 0.15),
    (0.25, 0.15, 0.60),
)
"""Car paint: median 0.075, quartiles 0.03 and 0.15, as calibrated LIDARs of 865 nm report on the bodies of labelled
cars (docs/realism.md). Metallic paint returns little off its mirror direction. The ends are estimates."""
SHADES = (
    (0.20, 0.02, 0.06),  # black: carbon-black paints absorb near infrared too
    (0.20, 0.10, 0.20),  # dark metallic
    (0.30, 0.30, 0.50),  # silver and grey
    (0.30, 0.60, 0.80),  # white
)
"""Other actors: engineering estimates of ranges and shares, not to be quoted as fact."""
CARS = (Kind.CAR, Kind.SUV, Kind.VAN)
"""Kinds of the labelled cars."""


def paint_reflectivity(seed: int, name: str, kind: Kind) -> float:
    """Draw the diffuse reflectivity of one actor, 0 to 1, by (seed, name) from the shades of its kind."""
    rng = actor_rng(seed, name, Stream.PAINT)
    shades = CAR_SHADES if kind in CARS else SHADES
    shares = [share for share, _, _ in shades]
    _, low, high = shades[rng.choice(len(shades), p=shares)]
    return float(rng.uniform(low, high))


Size = tuple[float, float, float]

RANGES: dict[tuple[Kind, Size], tuple[Size, Size]] = {
    (Kind.CAR, (5.0, 1.8, 1.5)): ((4.4, 1.75, 1.42), (5.0, 1.80, 1.50)),
    (Kind.CAR, (5.0, 2.0, 1.5)): ((4.4, 1.75, 1.42), (5.0, 1.90, 1.50)),  # highway-env
    (Kind.VAN, (5.0, 1.8, 1.5)): ((4.7, 1.75, 1.75), (5.0, 1.80, 2.00)),  # a van by its guiShape alone
    (Kind.VAN, (6.5, 2.16, 2.86)): ((5.3, 1.95, 2.30), (6.5, 2.10, 2.86)),
    (Kind.TRUCK, (7.1, 2.4, 2.4)): ((6.5, 2.30, 2.60), (7.1, 2.40, 3.40)),
    (Kind.TRAILER_TRUCK, (16.5, 2.55, 4.0)): ((15.5, 2.50, 3.80), (16.5, 2.55, 4.00)),
    (Kind.BUS, (12.0, 2.5, 3.4)): ((10.5, 2.45, 3.00), (12.0, 2.50, 3.40)),
    (Kind.BUS, (14.0, 2.6, 4.0)): ((12.5, 2.50, 3.50), (14.0, 2.60, 4.00)),
    (Kind.MOTORCYCLE, (2.2, 0.9, 1.5)): ((2.0, 0.70, 1.45), (2.2, 0.90, 1.65)),
    (Kind.MOTORCYCLE, (2.1, 0.78, 1.7)): ((1.8, 0.65, 1.55), (2.1, 0.78, 1.75)),  # moped
    (Kind.BICYCLE, (1.6, 0.65, 1.7)): ((1.5, 0.55, 1.60), (1.6, 0.65, 1.85)),
    (Kind.BICYCLE, (1.2, 0.5, 1.7)): ((1.0, 0.40, 1.60), (1.2, 0.50, 1.85)),  # scooter
    (Kind.PEDESTRIAN, (0.215, 0.478, 1.719)): ((0.20, 0.40, 1.55), (0.215, 0.478, 1.90)),
}
"""Lowest and highest length, width and height [m] by kind and default size. Articulated buses and rail vehicles are
left out, since their sizes vary little."""


def redrawn_size(kind: Kind, size: Size, seed: int, name: str) -> Size:
    """Return length, width and height [m] of an actor: drawn by (seed, name) if `size` is a default, else `size`."""
    if (kind, size) not in RANGES:
        return size
    low, high = RANGES[kind, size]
    length, width, height = actor_rng(seed, name, Stream.SIZE).uniform(low, high).tolist()
    return (length, width, height)
