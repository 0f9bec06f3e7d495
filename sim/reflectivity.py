"""Paint: diffuse reflectivity of actors at 905 nm."""

from luxloop.sim.actor_key import Stream, actor_rng
from luxloop.sim.world import Kind

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
