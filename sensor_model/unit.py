"""What a LIDAR unit is: its layers, where they fire, and how sensitive it is there. Data, read from `units/*.toml`."""

from dataclasses import dataclass

import numpy as np

_WHOLE_STEPS = 1e-6


@dataclass(frozen=True, slots=True)
class Fan:
    """Layers that fire at the same azimuths, in even steps from left to right (from high to low azimuth).

    A layer may be part of several fans, as when its step changes over the field of view.
    """

    layers: tuple[int, ...]
    start_deg: float
    """First azimuth in the unit's frame, left of the optical axis positive."""
    stop_deg: float
    """Last azimuth, a whole number of steps below `start_deg`."""
    step_deg: float
    """Positive."""
    gain_percent: tuple[float, ...]
    """Sensitivity at the model's `gain_azimuth_deg`, percent of the centre's."""

    def __post_init__(self) -> None:
        if not self.layers:
            raise ValueError("layers = []: name at least one layer")
        if self.step_deg <= 0.0:
            raise ValueError(f"step_deg = {self.step_deg}: must be positive")
        if self.stop_deg > self.start_deg:
            raise ValueError(f"stop_deg = {self.stop_deg}: must not exceed start_deg, the sweep runs to the right")
        if self.start_deg - self.stop_deg >= 360.0:
            raise ValueError(f"stop_deg = {self.stop_deg}: a fan covers less than a full turn; end one step earlier")
        steps = (self.start_deg - self.stop_deg) / self.step_deg
        if abs(steps - round(steps)) > _WHOLE_STEPS:
            raise ValueError(f"step_deg = {self.step_deg}: must divide start_deg - stop_deg into whole steps")

    @property
    def count(self) -> int:
        """Beams of one layer."""
        return round((self.start_deg - self.stop_deg) / self.step_deg) + 1


@dataclass(frozen=True, slots=True)
class UnitModel:
    """A type of LIDAR."""

    range_min_m: float
    """A surface nearer than this blocks the beam without an echo."""
    range_max_m: float
    pulse_length_m: float
    """Length of the laser pulse in space, the shortest echo pulse width."""
    layer_elevation_deg: tuple[float, ...]
    """Elevation of each layer's centre, up positive; layer 0 comes first and is the lowest."""
    layer_bias_m: tuple[float, ...]
    """Fixed range error of each layer."""
    gain_azimuth_deg: tuple[float, ...]
    """Azimuths at which the fans' `gain_percent` is known, falling; linear between them, constant beyond."""
    fans: tuple[Fan, ...]

    def __post_init__(self) -> None:
        layers = len(self.layer_elevation_deg)
        if not 0.0 <= self.range_min_m < self.range_max_m:
            raise ValueError(f"range_min_m = {self.range_min_m}: must be at least 0 and below range_max_m")
        if self.pulse_length_m <= 0.0:
            raise ValueError(f"pulse_length_m = {self.pulse_length_m}: must be positive")
        if len(self.layer_bias_m) != layers:
            raise ValueError(f"layer_bias_m = {list(self.layer_bias_m)}: give one number for each of {layers} layers")
        if np.any(np.diff(self.gain_azimuth_deg) >= 0.0):
            raise ValueError(f"gain_azimuth_deg = {list(self.gain_azimuth_deg)}: must fall from left to right")
        for fan in self.fans:
            if not all(0 <= layer < layers for layer in fan.layers):
                raise ValueError(f"layers = {list(fan.layers)}: layer_elevation_deg has layers 0 to {layers - 1}")
            if len(fan.gain_percent) != len(self.gain_azimuth_deg):
                raise ValueError(f"gain_percent = {list(fan.gain_percent)}: give one number for each gain_azimuth_deg")
