"""Random numbers that depend on nothing but what they are for.

Philox is a function of a key and a counter (Salmon et al., SC 2011). The key is the run's seed; the counter names
frame, unit, beam and purpose. So a draw does not change when a unit, an actor or another kind of noise comes or goes.
"""

from enum import IntEnum

import numpy as np
import numpy.typing as npt

from sensor_model.beams import BeamTable
from sensor_model.kernels import uniform_pairs

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]


class Purpose(IntEnum):
    """What a draw is for."""

    RANGE = 0
    DROPOUT = 1


class Draws:
    """The draws of one run.

    Parameters
    ----------
    seed
        Taken modulo 2^64.
    """

    def __init__(self, seed: int, beams: BeamTable) -> None:
        self._key = np.array([seed & 0xFFFFFFFF, (seed >> 32) & 0xFFFFFFFF], dtype=np.uint32)
        self._beams = beams

    def uniform(self, frame: int, beam: Ints, purpose: Purpose) -> Floats:
        """(2, H) independent draws in (0, 1) for H beams of the table."""
        pairs: Floats = uniform_pairs(self._key, frame, self._beams.unit[beam], self._beams.index[beam], int(purpose))
        return pairs

    def normal(self, frame: int, beam: Ints, purpose: Purpose) -> Floats:
        """(H,) standard normal draws, by Box and Muller (1958)."""
        u, v = self.uniform(frame, beam, purpose)
        normal: Floats = np.sqrt(-2.0 * np.log(u)) * np.cos(2.0 * np.pi * v)
        return normal
