"""Snow: echoes of flakes, and attenuation."""

from dataclasses import dataclass

from luxloop import elementary
from luxloop.sensor_model.noise.clutter_mixing import Clutter
from luxloop.sensor_model.noise.precipitation import falling_echoes, per_metre
from luxloop.sensor_model.noise.random_draws import Draws, Purpose
from luxloop.sensor_model.noise.thresholds import Thresholds
from luxloop.sensor_model.rig.beams import BeamTable
from luxloop.sensor_model.truth import Cause

FLAKES_PER_MM_PER_H = 0.01569
"""Share of the beams with an echo from a flake, per mm/h: 93 times that of rain. With the range below it was fitted to
a Velodyne VLP-16 (TU Darmstadt's open model; Linnhoff et al. 2022, Sensors 22). No figures are published for a LUX."""
LOG_RANGE = (1.4329, 0.7868)
"""Mean and standard deviation of the natural logarithm of a flake's range in metres; the median range is 4.2 m."""


@dataclass(frozen=True, slots=True)
class Snow:
    """Falling dry snow."""

    enabled: bool = False
    """If false, no snow falls."""
    rate_mm_per_h: float = 1.0
    """[mm/h] Snowfall as depth of melted water: below 1 is light, 1 to 2.5 moderate, above 2.5 heavy."""
    labelled: float = 0.5
    """Share of the flakes that the unit itself flags as clutter; an estimate."""

    def __post_init__(self) -> None:
        if not 0.0 < self.rate_mm_per_h <= 10.0:
            raise ValueError(f"rate_mm_per_h = {self.rate_mm_per_h}: must be above 0 and at most 10 for snow")
        if not 0.0 <= self.labelled <= 1.0:
            raise ValueError(f"labelled = {self.labelled}: must be from 0 to 1")


def extinction(config: Snow) -> float:
    """Return the extinction coefficient of dry snow [1/m]; 0 without snow.

    5.54 R^1.38 dB/km at R mm/h and 905 nm, for free-space optical links (ITU-R P.1817-1, table 2). At 2.5 mm/h that is
    4.5e-3 per metre, which reduces an echo at 50 m by 36 %.
    """
    if not config.enabled:
        return 0.0
    return per_metre(5.54 * elementary.power(config.rate_mm_per_h, 1.38))


def flakes(config: Snow, beams: BeamTable, thresholds: Thresholds, draws: Draws, frame: int) -> Clutter:
    """Draw the flakes that give an echo in a frame."""
    rate = FLAKES_PER_MM_PER_H * config.rate_mm_per_h
    purposes = (Purpose.SNOW, Purpose.SNOW_RANGE, Purpose.SNOW_LABEL)
    return falling_echoes(rate, LOG_RANGE, Cause.SNOW, config.labelled, purposes, beams, thresholds, draws, frame)
