"""Fog: attenuation, and the light that it scatters back from near the unit."""

import math
from dataclasses import dataclass

import numpy as np
import scipy

from luxloop import elementary, elementwise
from luxloop.arrays import Floats, Ints
from luxloop.sensor_model.noise.clutter_mixing import Clutter, droplets
from luxloop.sensor_model.noise.random_draws import Draws, Purpose
from luxloop.sensor_model.noise.thresholds import Thresholds
from luxloop.sensor_model.rig.beams import BeamTable
from luxloop.sensor_model.truth import Cause

BACKSCATTER = 0.046
"""[1/sr] Backscatter coefficient of fog times its visibility (Rasshofer et al. 2011; Hahner et al. 2021)."""
NEAR_M = 5.0
"""[m] Range up to which a unit suppresses the light scattered back by the air; an estimate, with which fog of 300 m
gives almost no echoes, as in natural fog (Linnhoff et al. 2022), and fog below 100 m gives many, as in fog chambers
(Bijelic et al. 2018)."""
PATCHINESS = 0.5
"""Standard deviation of the natural logarithm of the fog's density from one pulse length to the next; an estimate."""
_CELLS = 16
"""Pulse lengths from `NEAR_M` on that can give an echo: even the densest patch beyond is below the threshold."""


@dataclass(frozen=True, slots=True)
class Fog:
    """Fog of even mean density."""

    enabled: bool = False
    """If false, the air is clear of fog."""
    visibility_m: float = 200.0
    """[m] Meteorological optical range, at which 5 % of the light of a beam is left: below 1000 is fog, below 200 dense
    fog."""
    labelled: float = 0.5
    """Share of the echoes of fog that the unit itself flags as clutter; an estimate."""

    def __post_init__(self) -> None:
        if not 20.0 <= self.visibility_m <= 10_000.0:  # the echoes of denser fog are nearer than `NEAR_M`
            raise ValueError(f"visibility_m = {self.visibility_m}: must be from 20 to 10000")
        if not 0.0 <= self.labelled <= 1.0:
            raise ValueError(f"labelled = {self.labelled}: must be from 0 to 1")


def extinction(config: Fog) -> float:
    """Return the extinction coefficient of fog [1/m]; 0 without fog.

    ln(20) / visibility (Koschmieder 1924, with the contrast of 5 % of the World Meteorological Organization), equal for
    905 nm and for visible light, since droplets of fog are larger than both. At a visibility of 50 m a plate of 10 % is
    lost at 17.5 m instead of 50 m.
    """
    return elementary.log(20.0) / config.visibility_m if config.enabled else 0.0


class FogEchoes:
    """Echoes of fog in a run.

    Fog is a soft target: within a pulse length L at the range r it returns the power pi b L g exp(-2 alpha r) / r^2
    with the backscatter coefficient b, as a Lambertian surface of the reflectivity pi b L would. The density varies
    from pulse length to pulse length by a lognormal factor. The first one whose power reaches the unit's threshold is
    the echo. A raised threshold keeps its share of them, as of raindrops.
    """

    def __init__(self, config: Fog, beams: BeamTable) -> None:
        self._config = config
        self._beams = beams
        self._all = np.arange(len(beams))
        self._length = beams.units.pulse_length[beams.unit]
        self._echo_by = echo_by(config, beams)

    def draw(self, thresholds: Thresholds, draws: Draws, frame: int) -> Clutter:
        """Draw the echoes of fog in a frame."""
        chance, within = draws.uniform(frame, self._all, Purpose.FOG)
        beam: Ints = np.flatnonzero(chance < self._echo_by[:, -1])
        cell = (self._echo_by[beam] <= chance[beam, None]).sum(axis=1)
        range_ = NEAR_M + (cell + within[beam]) * self._length[beam]
        labels = draws.uniform(frame, beam, Purpose.FOG_LABEL)
        return droplets(beam, range_, Cause.FOG, self._config.labelled, labels, self._beams, thresholds)


def echo_by(config: Fog, beams: BeamTable) -> Floats:
    """Return the (B, `_CELLS`) probability that a beam has an echo within so many pulse lengths after `NEAR_M`."""
    unit = beams.unit[:, None]
    length, threshold = beams.units.pulse_length[unit], beams.units.threshold[unit]
    range_ = NEAR_M + (np.arange(_CELLS) + 0.5) * length
    backscatter = BACKSCATTER / config.visibility_m
    mean = math.pi * backscatter * length * beams.gain[:, None] / range_**2
    mean *= elementwise.exp(-2.0 * extinction(config) * range_)
    with np.errstate(divide="ignore"):  # no gain: no echo
        echo = scipy.special.ndtr(elementwise.log(mean / threshold) / PATCHINESS)
    probability: Floats = 1.0 - np.cumprod(1.0 - echo, axis=1)
    return probability
