"""Paint: diffuse reflectivity of actors at 905 nm."""

import numpy as np

SHADES = (
    # share, lowest, highest diffuse reflectivity
    (0.20, 0.02, 0.06),  # black: carbon-black paints absorb near infrared too
    (0.20, 0.10, 0.20),  # dark metallic
    (0.30, 0.30, 0.50),  # silver and grey
    (0.30, 0.60, 0.80),  # white
)
"""Engineering estimates of ranges and shares: tunable, not to be quoted as fact."""

_PAINT_STREAM = 1


def paint_reflectivity(seed: int, actor_id: int) -> float:
    """Draw the diffuse reflectivity of one actor, 0 to 1.

    The draw is keyed by (seed, actor), so it does not depend on the other actors.
    """
    rng = actor_rng(seed, actor_id, _PAINT_STREAM)
    shares = [share for share, _, _ in SHADES]
    _, low, high = SHADES[rng.choice(len(SHADES), p=shares)]
    return float(rng.uniform(low, high))


def actor_rng(seed: int, actor_id: int, stream: int) -> np.random.Generator:
    """Return the random generator of one actor and purpose: Philox, keyed by (seed, actor), `stream` in its counter.

    The seed is taken modulo 2^64.
    """
    key = np.array([seed % 2**64, actor_id], dtype=np.uint64)
    return np.random.Generator(np.random.Philox(key=key, counter=[0, 0, 0, stream]))
