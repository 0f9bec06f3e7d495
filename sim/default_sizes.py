"""Random sizes in place of a simulator's default sizes, which make all cars alike and longer than most.

SUMO's default car is 5.0 m x 1.8 m x 1.5 m, highway-env's 5.0 m x 2.0 m. A body of exactly a default size gets a random
size of its class. It is never longer or wider than the default, which is the space that the simulator keeps clear. The
height may be larger, since neither simulator considers heights in collisions. The ranges are engineering estimates.
"""

from luxloop.sim.actor_key import Stream, actor_rng
from luxloop.sim.world import Kind

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
