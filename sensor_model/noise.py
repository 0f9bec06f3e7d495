"""What happens to beams between the surface and the reported range. Each kind of noise has its own switch."""

import math
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
from scipy.special import expit

from sensor_model.beams import BeamTable
from sensor_model.cast import Hits
from sensor_model.draws import Draws, Purpose
from sensor_model.truth import Loss

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

KEPT = -1
"""In the result of `lost_beams`: the beam returned."""

_LOGISTIC_10_TO_90 = 2.0 * math.log(9.0)  # width of the standard logistic between these shares
_TINY_POWER = 1e-30  # stands for none at all, in 1/m^2


@dataclass(frozen=True, slots=True)
class RangeNoise:
    """Error of the reported range, along the beam."""

    enabled: bool = True
    """If not, ranges are exact."""
    sigma_m: float = 0.025
    """Standard deviation; 2.5 cm is what the TU Darmstadt model of the LUX uses."""
    layer_bias_scale: float = 1.0
    """Multiplies the fixed range error of each layer, `layer_bias_m` of the unit's file."""
    quantum_m: float = 0.01
    """Ranges are rounded to whole quanta; the LUX reports centimetres. 0 does not round."""

    def __post_init__(self) -> None:
        if not 0.0 <= self.sigma_m < math.inf:
            raise ValueError(f"sigma_m = {self.sigma_m}: must not be negative; use 0 for none")
        if not math.isfinite(self.layer_bias_scale):
            raise ValueError(f"layer_bias_scale = {self.layer_bias_scale}: must be finite; use 0 for no bias")
        if not 0.0 <= self.quantum_m < math.inf:
            raise ValueError(f"quantum_m = {self.quantum_m}: must not be negative; use 0 to not round")


@dataclass(frozen=True, slots=True)
class Dropout:
    """Beams that meet something and return nothing."""

    enabled: bool = True
    """If not, every beam that meets something within range returns."""
    threshold_per_m2: float = 4e-5
    """Received power reflectivity x cos(incidence) x gain / range^2 at which half the beams return [1/m^2].

    The LUX sees a reflectivity of 10 % at 50 m: 0.1 / 50^2.
    """
    softness_db: float = 1.0
    """Rise of power over which the share of beams that return goes from 10 to 90 %, along a logistic; an estimate."""
    random_rate: float = 0.01
    """Fraction of beams lost whatever their power; an estimate."""

    def __post_init__(self) -> None:
        if not 0.0 < self.threshold_per_m2 < math.inf:
            raise ValueError(f"threshold_per_m2 = {self.threshold_per_m2}: must be positive; 1e-12 loses nothing")
        if not 0.0 < self.softness_db < math.inf:
            raise ValueError(f"softness_db = {self.softness_db}: must be positive; use 0.001 for a hard threshold")
        if not 0.0 <= self.random_rate <= 1.0:
            raise ValueError(f"random_rate = {self.random_rate}: must be from 0 to 1")


@dataclass(frozen=True, slots=True)
class MirrorNoise:
    """Points on side mirrors, which stick out of the vehicle's outline."""

    enabled: bool = True
    """If not, vehicles have no side mirrors."""


@dataclass(frozen=True, slots=True)
class LayerOverlap:
    """Layers that meet a vehicle at different depths, as bumper and rear window."""

    enabled: bool = True
    """If not, every body is its plain bounding prism from the ground to its height, so that all layers see the same
    outline; side mirrors stay."""


@dataclass(frozen=True, slots=True)
class NoiseConfig:
    """All kinds of noise."""

    range: RangeNoise = field(default_factory=RangeNoise)
    dropout: Dropout = field(default_factory=Dropout)
    mirror: MirrorNoise = field(default_factory=MirrorNoise)
    layer_overlap: LayerOverlap = field(default_factory=LayerOverlap)


def received_power(hits: Hits, beams: BeamTable) -> Floats:
    """(H,) power of each echo: reflectivity x cos(incidence) x gain / range^2 (Lambert, extended target) [1/m^2]."""
    power: Floats = hits.reflectivity * hits.cosine * beams.gain[hits.beam] / hits.range**2
    return power


def lost_beams(hits: Hits, beams: BeamTable, config: Dropout, draws: Draws, frame: int) -> npt.NDArray[np.int8]:
    """(H,) `Loss` of each beam that met something, or `KEPT`."""
    loss = np.full(len(hits.beam), KEPT, dtype=np.int8)
    if not config.enabled:
        return loss
    by_power, by_chance = draws.uniform(frame, hits.beam, Purpose.DROPOUT)
    power = np.maximum(received_power(hits, beams), _TINY_POWER)
    margin_db = 10.0 * np.log10(power / config.threshold_per_m2)
    loss[by_chance < config.random_rate] = Loss.RANDOM
    loss[by_power > expit(_LOGISTIC_10_TO_90 * margin_db / config.softness_db)] = Loss.THRESHOLD
    return loss


def measured_range(
    beam: Ints, true_range: Floats, beams: BeamTable, config: RangeNoise, draws: Draws, frame: int
) -> Floats:
    """(N,) range that a unit reports for each returned beam [m]."""
    if not config.enabled:
        return true_range
    error = config.sigma_m * draws.normal(frame, beam, Purpose.RANGE)
    error += config.layer_bias_scale * beams.layer_bias[beam]
    measured = np.maximum(true_range + error, 0.0)
    if config.quantum_m > 0.0:
        measured = np.round(measured / config.quantum_m) * config.quantum_m
    return measured
