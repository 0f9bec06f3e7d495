"""Counter-based random draws.

Philox is a function of a key and a counter (Salmon et al., SC 2011). The key is the run's seed; the counter is made of
frame, unit, beam and purpose. A draw therefore does not depend on other units, actors or kinds of noise, nor on the
order of the frames.
"""

from enum import IntEnum

import numpy as np

from luxloop import elementwise
from luxloop.arrays import Floats, Ints
from luxloop.sensor_model.kernels.noise import beam_pairs, counter_pairs
from luxloop.sensor_model.rig.beams import BeamTable

_WORD = 0xFFFFFFFF
_NUMBER = 256  # exceeds the number of purposes


class Purpose(IntEnum):
    """Purpose of a draw. The numbers are part of every recorded run: add new ones at the end."""

    RANGE = 0
    DROPOUT = 1
    OUTAGE = 2
    OUTLIER = 3
    FALSE_ALARM = 4
    FALSE_ALARM_RANGE = 5
    RAIN = 6
    RAIN_RANGE = 7
    RAIN_LABEL = 8
    SPRAY_BIRTH = 9
    SPRAY_PLACE = 10
    SPRAY_HEIGHT = 11
    SPRAY_RADIUS = 12
    SPRAY_ECHO = 13
    SPRAY_LABEL = 14
    MOUNT = 15
    SYNC = 16
    PITCH = 17
    ROLL = 18
    ODOMETRY = 19
    YAW_WALK = 20
    PULSE_WIDTH = 21
    CLUTTER_FLAG = 22
    FALSE_ALARM_POWER = 23
    SNOW = 24
    SNOW_RANGE = 25
    SNOW_LABEL = 26
    FOG = 27
    FOG_LABEL = 28


class Draws:
    """Random draws of one run.

    Parameters
    ----------
    seed
        Seed of the run, modulo 2^64.
    """

    def __init__(self, seed: int, beams: BeamTable) -> None:
        self.key = np.array([seed & _WORD, (seed >> 32) & _WORD], dtype=np.uint32)
        self._beams = beams

    def uniform(self, frame: int, beam: Ints, purpose: Purpose, number: Ints | int = 0) -> Floats:
        """Return (2, H) draws in (0, 1) for H beams of the table; `number` distinguishes those of one beam."""
        of = np.empty(len(beam), dtype=np.int64)
        of[:] = purpose + _NUMBER * number
        pairs: Floats = beam_pairs(self.key, frame, self._beams.unit, self._beams.index, beam, of)
        return pairs

    def normal(self, frame: int, beam: Ints, purpose: Purpose, number: Ints | int = 0) -> Floats:
        """Return (H,) standard normal draws for H beams of the table; `number` distinguishes those of one beam."""
        return _normal(self.uniform(frame, beam, purpose, number))

    def uniform_of(self, frame: Ints | int, first: Ints | int, second: Ints | int, purpose: Purpose) -> Floats:
        """Return (2, N) independent draws in (0, 1) for counters of up to three integers, which broadcast to (N,)."""
        counters = np.empty((4, np.broadcast(frame, first, second).size), dtype=np.int64)
        for row, counter in enumerate((frame, first, second, int(purpose))):
            counters[row] = np.bitwise_and(counter, _WORD)
        pairs: Floats = counter_pairs(self.key, *counters)
        return pairs

    def normal_of(self, frame: Ints | int, first: Ints | int, second: Ints | int, purpose: Purpose) -> Floats:
        """Return (N,) standard normal draws for counters of up to three integers."""
        return _normal(self.uniform_of(frame, first, second, purpose))


def _normal(uniform: Floats) -> Floats:
    """Return (N,) standard normal numbers from (2, N) uniform ones, by Box and Muller (1958)."""
    normal: Floats = np.sqrt(-2.0 * elementwise.log(uniform[0])) * elementwise.cos(2.0 * np.pi * uniform[1])
    return normal
