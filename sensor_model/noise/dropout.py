"""Dropout: soft detection threshold, and random losses."""

import math
from dataclasses import dataclass

import numpy as np

from luxloop import elementary, elementwise
from luxloop.arrays import Bools, Floats
from luxloop.sensor_model.kernels.noise import TABLE_BITS, soft_thresholds
from luxloop.sensor_model.noise.random_draws import Draws, Purpose
from luxloop.sensor_model.rig.beams import BeamTable

_LOGISTIC_10_TO_90 = 2.0 * math.log(9.0)  # width of the standard logistic distribution between these shares


@dataclass(frozen=True, slots=True)
class Dropout:
    """Lost echoes of a healthy detector."""

    enabled: bool = True
    """If false, an echo is detected if and only if it reaches the threshold of its unit."""
    softness_db: float = 1.0
    """[dB] Increase of the received power over which the detection probability rises from 10 to 90 %, along a logistic
    curve; an estimate."""
    random_rate: float = 0.01
    """Share of beams lost at random, at any power; an estimate; 0.005 to 0.02 is plausible."""

    def __post_init__(self) -> None:
        if not 0.0 <= self.softness_db <= 20.0:
            raise ValueError(f"softness_db = {self.softness_db}: must be from 0, a hard threshold, to 20")
        if not 0.0 <= self.random_rate <= 1.0:
            raise ValueError(f"random_rate = {self.random_rate}: must be from 0 to 1")


class Sensitivity:
    """Soft detection thresholds of one run.

    A unit of threshold K detects an echo of power P with the probability 1 / (1 + exp(-m / s)), m = 10 log10(P / K).
    The threshold of a shot is therefore K in decibels plus a logistic draw of scale s = softness_db / (2 ln 9), taken
    from a table of its quantiles.
    """

    def __init__(self, config: Dropout, beams: BeamTable, draws: Draws) -> None:
        self._config = config
        self._beams = beams
        self._draws = draws
        quantile = (np.arange(2**TABLE_BITS) + 0.5) / 2**TABLE_BITS
        logistic_db = config.softness_db / _LOGISTIC_10_TO_90 * elementwise.log(quantile / (1.0 - quantile))
        self._factor: Floats = elementwise.exp(elementary.LN_10 * logistic_db / 10.0)

    def threshold(self, frame: int) -> tuple[Floats, Bools]:
        """Return the (B,) threshold of each beam in a frame [1/m^2], and the (B,) mask of beams lost at random."""
        beams = self._beams
        threshold: Floats
        lost: Bools
        threshold, lost = soft_thresholds(
            self._draws.key, frame, int(Purpose.DROPOUT), beams.unit, beams.index,
            beams.units.threshold, self._factor, self._config.random_rate,
        )  # fmt: skip
        return threshold, lost
