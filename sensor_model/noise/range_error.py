"""Noise of the receiver: random error and fixed bias of a reported range and echo pulse width."""

import math
from dataclasses import dataclass

import numpy as np

from luxloop.arrays import Floats, Ints
from luxloop.sensor_model.noise.random_draws import Draws, Purpose
from luxloop.sensor_model.rig.beams import BeamTable


@dataclass(frozen=True, slots=True)
class RangeNoise:
    """Error of the reported range, along the beam, and of the echo pulse width. The unit file has their sizes."""

    enabled: bool = True
    """If false, ranges and pulse widths are exact."""
    sigma_scale: float = 1.0
    """Factor of the unit's `range_sigma_m` and `range_sigma_far_m`."""
    layer_bias_scale: float = 1.0
    """Factor of the fixed range error of each layer, the unit's `layer_bias_m`."""

    def __post_init__(self) -> None:
        if not 0.0 <= self.sigma_scale < math.inf:
            raise ValueError(f"sigma_scale = {self.sigma_scale}: must not be negative; use 0 for none")
        if not math.isfinite(self.layer_bias_scale):
            raise ValueError(f"layer_bias_scale = {self.layer_bias_scale}: must be finite; use 0 for no bias")


def range_error(
    config: RangeNoise, beam: Ints, true_range: Floats, place: Ints, beams: BeamTable, draws: Draws, frame: int
) -> Floats:
    """Return the (N,) range error of each echo [m]: a normal draw plus the bias of its layer.

    Detector noise moves the leading edge by noise / slope. The slope is proportional to the power, falling as 1 / r^2.
    Up to the reference range R the variance is therefore s^2 + (s_far^2 - s^2) (r / R)^4, and it is s_far^2 beyond.

    Parameters
    ----------
    true_range
        (N,) ranges of the leading edges [m].
    place
        (N,) number that distinguishes the echoes of a beam.
    """
    unit = beams.unit.take(beam)
    near, far = beams.units.range_sigma.take(unit) ** 2, beams.units.range_sigma_far.take(unit) ** 2
    share = np.minimum(true_range / beams.units.reference_range.take(unit), 1.0) ** 2
    error = draws.normal(frame, beam, Purpose.RANGE, place)
    error *= config.sigma_scale * np.sqrt(near + (far - near) * share**2)
    error += config.layer_bias_scale * beams.layer_bias.take(beam)
    return error


def width_error(beam: Ints, place: Ints, beams: BeamTable, draws: Draws, frame: int) -> Floats:
    """Return the (N,) error of each echo pulse width [m]: a normal draw plus the bias of its layer."""
    sigma = beams.units.pulse_sigma.take(beams.unit.take(beam))
    return sigma * draws.normal(frame, beam, Purpose.PULSE_WIDTH, place) + beams.layer_pulse_bias.take(beam)
