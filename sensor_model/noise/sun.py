"""Beams that look towards the sun."""

from dataclasses import dataclass

import numpy as np

from sensor_model.arrays import Bools
from sensor_model.rig.beams import BeamTable


@dataclass(frozen=True, slots=True)
class Sun:
    """A low sun, which raises the noise of the detector and makes the unit less sensitive."""

    enabled: bool = False
    """If not, the sky is overcast."""
    azimuth_deg: float = 0.0
    """[deg] Where the sun stands in the world frame, counter-clockwise from x (east)."""
    half_width_deg: float = 15.0
    """[deg] Beams within this of the sun's azimuth are sunlit; an estimate."""
    gain: float = 0.6
    """Sensitivity of sunlit beams. The unit's own firmware goes down to 0.6 in direct sunlight (SICK LD-MRS parameter
    0x110B, from the driver `libsick_ldmrs`)."""

    def __post_init__(self) -> None:
        if not -360.0 <= self.azimuth_deg <= 360.0:
            raise ValueError(f"azimuth_deg = {self.azimuth_deg}: must be from -360 to 360")
        if not 0.0 < self.half_width_deg <= 180.0:
            raise ValueError(f"half_width_deg = {self.half_width_deg}: must be above 0 and at most 180")
        if not 0.0 < self.gain <= 1.0:
            raise ValueError(f"gain = {self.gain}: must be above 0 and at most 1; use an outage to silence a unit")


class Glare:
    """Which beams are sunlit."""

    def __init__(self, config: Sun, beams: BeamTable) -> None:
        self._azimuth = np.deg2rad(config.azimuth_deg)
        self._narrowest = np.cos(np.deg2rad(config.half_width_deg))
        horizontal = beams.direction_ego[:, :2]
        self._heading_ego = horizontal / np.linalg.norm(horizontal, axis=1, keepdims=True)

    def sunlit(self, ego_yaw_world: float) -> Bools:
        """(B,) beams within the half width of the sun, for a heading of the ego [rad]."""
        towards_ego = self._azimuth - ego_yaw_world
        sun_ego = np.array([np.cos(towards_ego), np.sin(towards_ego)])
        sunlit: Bools = self._heading_ego @ sun_ego >= self._narrowest
        return sunlit
