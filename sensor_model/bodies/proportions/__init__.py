"""Proportions that vary between vehicles of one kind and size, drawn per actor within the ranges of its kind.

All ranges are engineering estimates around published dimensions: bumper faces at 0.41 to 0.51 m (49 CFR 581), hood
edges below 0.76 m on low cars and up to 1.02 m on medium ones, windscreens not below 28 degrees, sides that lean
inwards by 15 to 22 degrees on sedans and hardly on vans. Every draw uses the same counter-based generator, keyed by
(seed, name of the actor), so an actor's body does not depend on other actors.
"""

from luxloop.sim.actor_draws import Stream, actor_rng


class Draw:
    """Sequence of uniform draws from ranges, reproducible by seed and actor.

    Parameters
    ----------
    seed
        Seed of the run, modulo 2^64; None returns the middle of every range.
    name
        Name of the actor.
    """

    def __init__(self, seed: int | None, name: str = "") -> None:
        self._random = None if seed is None else actor_rng(seed, name, Stream.PROPORTIONS).random

    def __call__(self, low: float, high: float) -> float:
        """Return a uniform draw between low and high."""
        return low + (high - low) * (0.5 if self._random is None else self._random())
