"""Pitch and roll of the ego's body on a rough road."""

import math
from dataclasses import dataclass

import numpy as np

from luxloop import elementary, elementwise
from luxloop.arrays import Floats
from luxloop.sensor_model.noise.random_draws import Draws, Purpose

_COSINES = 64
_RUN = 0  # frame number of draws made once per run


@dataclass(frozen=True, slots=True)
class AttitudeNoise:
    """Attitude of the ego's body relative to that of the world record: a constant part and a random motion.

    The body rotates about the origin of the ego frame. Positive pitch is nose down, positive roll right side down.

    The random motion is the suspension's response to the road, so it grows with the speed. By ISO 8608 the height of a
    road has a power spectral density of G n^-2 over the spatial frequency n: as a function of time its slope is white
    noise with a density proportional to the speed, and the standard deviation of a linear suspension's response is
    proportional to the square root of the speed. A standing car does not sway.
    """

    enabled: bool = True
    """If false, the ego is level and the other keys have no effect."""
    pitch_deg: float = 0.0
    """[deg] Constant pitch, for example of a sagging axle; negative with a loaded boot."""
    roll_deg: float = 0.0
    """[deg] Constant roll."""
    pitch_sigma_deg: float = 0.3
    """[deg] Standard deviation of the pitch from `full_from_mps` on. A road of class C by ISO 8608 gives 0.29 with a
    wheelbase of 2.8 m and a suspension of 1.5 Hz and damping 0.3, class B half as much."""
    roll_sigma_deg: float = 0.3
    """[deg] Standard deviation of the roll from `full_from_mps` on; an estimate: that of the pitch."""
    full_from_mps: float = 10.0
    """[m/s] Speed from which the motion has these standard deviations: above, the wheelbase averages the road. Below,
    they fall with the square root of the speed; 0 keeps them at all speeds."""
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
        if not 0.0 <= self.full_from_mps <= 100.0:
            raise ValueError(f"full_from_mps = {self.full_from_mps}: must be from 0 to 100")
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

    At a constant speed pitch and roll are independent stationary processes with an even spectrum between the two
    frequencies, each the sum of cosines sqrt(2 / n) sigma cos(2 pi f t + phase) with one random frequency in each of n
    even bands and random phases (spectral representation, Shinozuka and Deodatis 1991). Frequencies off a grid keep it
    from repeating itself.
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

    def at(self, time: float, speed: float) -> Floats:
        """Return (3, 3) rotation R of the body at a time [s]: level = R body, first pitch about y, then roll.

        Parameters
        ----------
        time
            Since the start of the run [s].
        speed
            Norm of the ego's velocity [m/s].
        """
        config = self._config
        if not config.enabled:
            return self._level
        share = math.sqrt(min(speed / config.full_from_mps, 1.0)) if config.full_from_mps else 1.0
        pitch_deg = config.pitch_deg + share * config.pitch_sigma_deg * self._wave(0, time)
        roll_deg = config.roll_deg + share * config.roll_sigma_deg * self._wave(1, time)
        pitch, roll = math.radians(pitch_deg), math.radians(roll_deg)
        (cp, sp), (cr, sr) = (
            (elementary.cos(pitch), elementary.sin(pitch)),
            (elementary.cos(roll), elementary.sin(roll)),
        )
        return np.array([[cp, sp * sr, sp * cr], [0.0, cr, -sr], [-sp, cp * sr, cp * cr]])

    def _wave(self, axis: int, time: float) -> float:
        """Return the value of the axis' process, which has variance 1."""
        rate, phase = self._waves[axis]
        return float(np.sqrt(2.0 / _COSINES) * elementwise.cos(rate * time + phase).sum())
