"""Counter-based random numbers: a pure function of a key and a counter."""

import numpy as np
import numpy.typing as npt

from luxloop.compiled import kernel

Key = npt.NDArray[np.uint32]
"""(2,) uint32 key of the generator."""

_MASK = np.uint64(0xFFFFFFFF)
_HALF = np.uint64(32)
_ONE_32 = 2.0**-32
_PHILOX_ROUNDS = 10
_PHILOX_M0, _PHILOX_M1 = np.uint64(0xD2511F53), np.uint64(0xCD9E8D57)
_PHILOX_W0, _PHILOX_W1 = np.uint64(0x9E3779B9), np.uint64(0xBB67AE85)


@kernel(inline="always")  # the compiler vectorises loops over the counters
def philox(c0: int, c1: int, c2: int, c3: int, k0: int, k1: int) -> tuple[np.uint64, np.uint64, np.uint64, np.uint64]:
    """Return four random 32-bit words of Philox4x32-10 (Salmon et al., SC 2011), counter c and key k below 2^32."""
    w0, w1, w2, w3 = np.uint64(c0), np.uint64(c1), np.uint64(c2), np.uint64(c3)
    key0, key1 = np.uint64(k0), np.uint64(k1)
    for _ in range(_PHILOX_ROUNDS):
        p0, p1 = _PHILOX_M0 * w0, _PHILOX_M1 * w2
        w0, w1, w2, w3 = (p1 >> _HALF) ^ w1 ^ key0, p1 & _MASK, (p0 >> _HALF) ^ w3 ^ key1, p0 & _MASK
        key0, key1 = (key0 + _PHILOX_W0) & _MASK, (key1 + _PHILOX_W1) & _MASK
    return w0, w1, w2, w3


@kernel()
def uniform(word: np.uint64) -> float:
    """Convert a random 32-bit word to a number in (0, 1)."""
    return (float(word) + 0.5) * _ONE_32
