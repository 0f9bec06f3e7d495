"""Range noise: random error and fixed bias of a reported range."""

import math
from dataclasses import dataclass

from sensor_model.arrays import Floats, Ints
from sensor_model.noise.random_draws import Draws, Purpose
from sensor_model.rig.beams import BeamTable


@dataclass(frozen=True, slots=True)
class RangeNoise:
    """Error of the reported range, along the beam. The unit file has its size; these keys scale it."""

    enabled: bool = True
    """If false, ranges are exact."""
    sigma_scale: float = 1.0
    """Factor of the unit's `range_sigma_m`; the TU Darmstadt model of the LUX uses 2.5 cm."""
    layer_bias_scale: float = 1.0
    """Factor of the fixed range error of each layer, the unit's `layer_bias_m`."""

    def __post_init__(self) -> None:
        if not 0.0 <= self.sigma_scale < math.inf:
            raise ValueError(f"sigma_scale = {self.sigma_scale}: must not be negative; use 0 for none")
        if not math.isfinite(self.layer_bias_scale):
            raise ValueError(f"layer_bias_scale = {self.layer_bias_scale}: must be finite; use 0 for no bias")


def range_error(config: RangeNoise, beam: Ints, place: Ints, beams: BeamTable, draws: Draws, frame: int) -> Floats:
    """Return the (N,) range error of each echo [m]: a normal draw plus the bias of its layer.

    `place` (N,) distinguishes the echoes of a beam.
    """
    sigma = beams.units.range_sigma.take(beams.unit.take(beam))
    error = draws.normal(frame, beam, Purpose.RANGE, place)
    error *= config.sigma_scale * sigma
    error += config.layer_bias_scale * beams.layer_bias.take(beam)
    return error
