"""Paint: diffuse reflectivity of actors at 905 nm."""

from luxloop.sim.actor_key import Stream, actor_rng

SHADES = (
    # share, lowest, highest diffuse reflectivity
    (0.20, 0.02, 0.06),  # black: carbon-black paints absorb near infrared too
    (0.20, 0.10, 0.20),  # dark metallic
    (0.30, 0.30, 0.50),  # silver and grey
    (0.30, 0.60, 0.80),  # white
)
"""Engineering estimates of ranges and shares: tunable, not to be quoted as fact."""


def paint_reflectivity(seed: int, name: str) -> float:
    """Draw the diffuse reflectivity of one actor, 0 to 1, by (seed, name)."""
    rng = actor_rng(seed, name, Stream.PAINT)
    shares = [share for share, _, _ in SHADES]
    _, low, high = SHADES[rng.choice(len(SHADES), p=shares)]
    return float(rng.uniform(low, high))
