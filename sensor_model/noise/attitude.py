"""Pitch and roll of the ego's body on its suspension."""

from dataclasses import dataclass

import numpy as np
import scipy

from sensor_model.arrays import Floats
from sensor_model.noise.random_draws import Draws, Purpose

_COSINES = 64
_RUN = 0  # frame number of draws made once per run


@dataclass(frozen=True, slots=True)
class AttitudeNoise:
    """Attitude of the ego's body relative to the level road: a constant part and a random motion.

    The body rotates about the origin of the ego frame.

    Positive pitch is nose down, positive roll right side down.
    """

    enabled: bool = False
    """If false, the ego is level and the other keys have no effect."""
    pitch_deg: float = 0.0
    """[deg] Constant pitch, for example under braking; negative with a loaded boot."""
    roll_deg: float = 0.0
    """[deg] Constant roll."""
    pitch_sigma_deg: float = 0.5
    """[deg] Standard deviation of the pitch in motion; an estimate; 0.5 to 1.0 on ordinary roads."""
    roll_sigma_deg: float = 0.5
    """[deg] Standard deviation of the roll in motion; an estimate."""
    slowest_hz: float = 0.5
    """[Hz] Lowest frequency of the motion; an estimate."""
    fastest_hz: float = 2.5
    """[Hz] Highest frequency of the motion. Car bodies bounce at 1 to 2 Hz."""

    def __post_init__(self) -> None:
        for name in ("pitch_deg", "roll_deg"):
            if not -10.0 <= getattr(self, name) <= 10.0:
                raise ValueError(f"{name} = {getattr(self, name)}: must be from -10 to 10")
        for name in ("pitch_sigma_deg", "roll_sigma_deg"):
            if not 0.0 <= getattr(self, name) <= 5.0:
                raise ValueError(f"{name} = {getattr(self, name)}: must be from 0 to 5")
        for name in ("pitch", "roll"):
            constant, sigma = getattr(self, f"{name}_deg"), getattr(self, f"{name}_sigma_deg")
            # Beyond that, a unit at a corner of the ego would be below the road.
            if abs(constant) + 3.0 * sigma > 10.0:
                raise ValueError(
                    f"{name}_sigma_deg = {sigma}: |{name}_deg| + 3 sigma must be at most 10; lower one of them"
                )
        if not 0.0 < self.slowest_hz < self.fastest_hz <= 100.0:
            raise ValueError(f"fastest_hz = {self.fastest_hz}: must be above slowest_hz and at most 100")


class Attitude:
    """Attitude of one run as a function of time.

    Pitch and roll are independent stationary processes with an even spectrum between the two frequencies, each the sum
    of cosines sqrt(2 / n) sigma cos(2 pi f t + phase) with one random frequency in each of n even bands and random
    phases (spectral representation, Shinozuka and Deodatis 1991). Frequencies off a grid keep it from repeating itself.
    """

    def __init__(self, config: AttitudeNoise, draws: Draws) -> None:
        self._config = config
        band = np.arange(_COSINES)
        self._waves = []
        for purpose in (Purpose.PITCH, Purpose.ROLL):
            place, phase = draws.uniform_of(_RUN, band, 0, purpose)
            frequency = config.slowest_hz + (config.fastest_hz - config.slowest_hz) * (band + place) / _COSINES
            self._waves.append(2.0 * np.pi * np.stack([frequency, phase]))
        self._level = np.eye(3)

    def at(self, time: float) -> Floats:
        """Return (3, 3) rotation R of the body at a time [s]: level = R body, first pitch about y, then roll."""
        config = self._config
        if not config.enabled:
            return self._level
        pitch_deg = config.pitch_deg + config.pitch_sigma_deg * self._wave(0, time)
        roll_deg = config.roll_deg + config.roll_sigma_deg * self._wave(1, time)
        return np.asarray(
            scipy.spatial.transform.Rotation.from_euler("YX", [pitch_deg, roll_deg], degrees=True).as_matrix()
        )

    def _wave(self, axis: int, time: float) -> float:
        """Return the value of the axis' process, which has variance 1."""
        rate, phase = self._waves[axis]
        return float(np.sqrt(2.0 / _COSINES) * np.cos(rate * time + phase).sum())
