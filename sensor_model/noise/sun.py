"""Glare of a low sun."""

from dataclasses import dataclass

import numpy as np

from luxloop import elementwise
from luxloop.arrays import Bools
from luxloop.sensor_model.rig.beams import BeamTable


@dataclass(frozen=True, slots=True)
class Sun:
    """Low sun, which raises the detector noise and reduces the sensitivity of the unit."""

    enabled: bool = False
    """If false, the sky is overcast."""
    azimuth_deg: float = 0.0
    """[deg] Azimuth of the sun in the world frame, counter-clockwise from x (east)."""
    half_width_deg: float = 15.0
    """[deg] Beams within this angle of the sun's azimuth are sunlit; an estimate."""
    gain: float = 0.6
    """Sensitivity of sunlit beams. The firmware of the unit reduces it to 0.6 in direct sunlight (SICK LD-MRS parameter
    0x110B, from the driver `libsick_ldmrs`)."""

    def __post_init__(self) -> None:
        if not -360.0 <= self.azimuth_deg <= 360.0:
            raise ValueError(f"azimuth_deg = {self.azimuth_deg}: must be from -360 to 360")
        if not 0.0 < self.half_width_deg <= 180.0:
            raise ValueError(f"half_width_deg = {self.half_width_deg}: must be above 0 and at most 180")
        if not 0.0 < self.gain <= 1.0:
            raise ValueError(f"gain = {self.gain}: must be above 0 and at most 1; use an outage to silence a unit")


class Glare:
    """Selection of the sunlit beams."""

    def __init__(self, config: Sun, beams: BeamTable) -> None:
        self._azimuth = np.deg2rad(config.azimuth_deg)
        self._narrowest = elementwise.cos(np.deg2rad(config.half_width_deg))
        horizontal = beams.direction_ego[:, :2]
        self._heading_ego = horizontal / np.linalg.norm(horizontal, axis=1, keepdims=True)

    def sunlit(self, ego_yaw_world: float) -> Bools:
        """Return the (B,) mask of beams within the half width of the sun, for a heading of the ego [rad]."""
        towards_ego = self._azimuth - ego_yaw_world
        sun_ego = np.array([elementwise.cos(towards_ego), elementwise.sin(towards_ego)])
        sunlit: Bools = elementwise.product(self._heading_ego, sun_ego) >= self._narrowest
        return sunlit
