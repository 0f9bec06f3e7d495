"""Facts of the LIDARs that a scan does not state."""

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class LidarConfig:
    """Noise and resolution of the LIDARs. Change all of it for units other than the IBEO LUX."""

    range_std_m: float = 0.027
    """Range noise along the beam [m]: a third of two steps of the LUX's distance resolution, 4 cm by its data sheet.
    Change it to the noise of your unit on a flat wall."""
    beam_deg: float = 0.5
    """Angle between beams of one layer [deg]; three of them, on a surface seen at a grazing angle, are no gap. Change
    it with the unit."""
    pitch_deg: float = 0.25
    """Angle between beams of all layers, which interleave, the accuracy of the end of a face [deg]. Change it with the
    unit."""

    def __post_init__(self) -> None:
        if not 1e-6 <= self.range_std_m <= 1e3:
            raise ValueError(f"range_std_m is {self.range_std_m}; give the noise in metres, above 0")
        for name in ("beam_deg", "pitch_deg"):
            if not 0.0 < getattr(self, name) < 90.0:
                raise ValueError(f"{name} is {getattr(self, name)}; give an angle above 0 and below 90 degrees")

    @property
    def beam_rad(self) -> float:
        """Angle between beams of one layer [rad]."""
        return math.radians(self.beam_deg)

    @property
    def pitch_rad(self) -> float:
        """Angle between beams of all layers [rad]."""
        return math.radians(self.pitch_deg)
