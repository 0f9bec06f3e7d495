"""Rain: echoes of drops, and attenuation."""

from dataclasses import dataclass

from luxloop import elementary
from luxloop.sensor_model.noise.clutter_mixing import Clutter
from luxloop.sensor_model.noise.precipitation import falling_echoes, per_metre
from luxloop.sensor_model.noise.random_draws import Draws, Purpose
from luxloop.sensor_model.noise.thresholds import Thresholds
from luxloop.sensor_model.rig.beams import BeamTable
from luxloop.sensor_model.truth import Cause


@dataclass(frozen=True, slots=True)
class Rain:
    """Falling rain.

    The constants of the drops were fitted to a Velodyne VLP-32 (TU Darmstadt's open model; Linnhoff et al. 2022,
    Sensors 22). No such figures are published for a LUX.
    """

    enabled: bool = False
    """If false, no rain falls."""
    rate_mm_per_h: float = 10.0
    """[mm/h] Rainfall: 2.5 is light, 10 heavy, 50 violent."""
    drops_per_mm_per_h: float = 1.69e-4
    """Share of the beams with an echo from a drop, per mm/h."""
    range_log_mean: float = 1.362
    """Mean of the natural logarithm of a drop's range in metres; the median range is 3.9 m."""
    range_log_sigma: float = 0.784
    """Standard deviation of that logarithm."""
    labelled: float = 0.5
    """Share of the drops that the unit itself flags as clutter; an estimate."""

    def __post_init__(self) -> None:
        if not 0.0 < self.rate_mm_per_h <= 200.0:
            raise ValueError(f"rate_mm_per_h = {self.rate_mm_per_h}: must be above 0 and at most 200")
        if not 0.0 < self.drops_per_mm_per_h * self.rate_mm_per_h <= 1.0:
            raise ValueError(f"drops_per_mm_per_h = {self.drops_per_mm_per_h}: times rate_mm_per_h must be 0 to 1")
        if not -5.0 <= self.range_log_mean <= 5.0:
            raise ValueError(
                f"range_log_mean = {self.range_log_mean}: must be from -5 to 5; 5 puts the median range at 148 m"
            )
        if not 0.0 < self.range_log_sigma <= 5.0:
            raise ValueError(f"range_log_sigma = {self.range_log_sigma}: must be above 0 and at most 5")
        if not 0.0 <= self.labelled <= 1.0:
            raise ValueError(f"labelled = {self.labelled}: must be from 0 to 1")


def extinction(config: Rain) -> float:
    """Return the extinction coefficient of rain [1/m]; 0 in dry air.

    The power exp(-extinction x path) remains.

    1.076 R^0.67 dB/km at R mm/h, for free-space optical links (Carbonneau and Wisely 1998, Proc. SPIE 3232). At
    10 mm/h that is 1.2e-3 per metre, which reduces an echo at 50 m by 11 %.
    """
    if not config.enabled:
        return 0.0
    return per_metre(1.076 * elementary.power(config.rate_mm_per_h, 0.67))


def drops(config: Rain, beams: BeamTable, thresholds: Thresholds, draws: Draws, frame: int) -> Clutter:
    """Draw the drops that give an echo in a frame; their ranges are lognormal."""
    rate = config.drops_per_mm_per_h * config.rate_mm_per_h
    log_range = (config.range_log_mean, config.range_log_sigma)
    purposes = (Purpose.RAIN, Purpose.RAIN_RANGE, Purpose.RAIN_LABEL)
    return falling_echoes(rate, log_range, Cause.RAIN, config.labelled, purposes, beams, thresholds, draws, frame)
