"""Random draws of an actor, keyed by its name: another actor's arrival changes none of them."""

from enum import IntEnum
from hashlib import blake2b

import numpy as np

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
