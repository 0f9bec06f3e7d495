"""The error of an ordinary range."""

import math
from dataclasses import dataclass

from sensor_model.arrays import Floats, Ints
from sensor_model.noise.random_draws import Draws, Purpose
from sensor_model.rig.beams import BeamTable


@dataclass(frozen=True, slots=True)
class RangeNoise:
    """Error of the reported range, along the beam. How large it is says the unit's file; here it is scaled."""

    enabled: bool = True
    """If not, ranges are exact."""
    sigma_scale: float = 1.0
    """Multiplies the unit's `range_sigma_m`; 2.5 cm is what the TU Darmstadt model of the LUX uses."""
    layer_bias_scale: float = 1.0
    """Multiplies the fixed range error of each layer, the unit's `layer_bias_m`."""

    def __post_init__(self) -> None:
        if not 0.0 <= self.sigma_scale < math.inf:
            raise ValueError(f"sigma_scale = {self.sigma_scale}: must not be negative; use 0 for none")
        if not math.isfinite(self.layer_bias_scale):
            raise ValueError(f"layer_bias_scale = {self.layer_bias_scale}: must be finite; use 0 for no bias")


def range_error(config: RangeNoise, beam: Ints, place: Ints, beams: BeamTable, draws: Draws, frame: int) -> Floats:
    """(N,) error of each echo [m]: a normal draw, and the bias of its layer.

    `place` (N,) tells the echoes of a beam apart.
    """
    sigma = beams.units.range_sigma.take(beams.unit.take(beam))
    error = draws.normal(frame, beam, Purpose.RANGE, place)
    error *= config.sigma_scale * sigma
    error += config.layer_bias_scale * beams.layer_bias.take(beam)
    return error
