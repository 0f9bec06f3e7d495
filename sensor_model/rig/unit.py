"""LIDAR unit models: layers, firing pattern and receiver.

The data are read from `units/*.toml`; docs/scenario-files.md explains every key.
"""

from dataclasses import dataclass

import numpy as np

_WHOLE_STEPS = 1e-6
_MAX_LAYERS = 256  # a point's layer is a byte
_POSITIVE = (
    "scan_rate_hz", "beam_width_deg", "beam_height_deg", "reference_reflectivity", "reference_range_m",
    "pulse_length_m", "pulse_quantum_m", "range_quantum_m", "echoes_max", "turns",
)  # fmt: skip
_NOT_NEGATIVE = ("range_min_m", "pulse_growth_m_per_db", "pulse_sigma_m", "echo_separation_m", "range_sigma_m")
_AT_MOST = {
    "scan_rate_hz": 1000.0, "beam_width_deg": 90.0, "beam_height_deg": 90.0, "range_max_m": 10_000.0,
    "reference_reflectivity": 10.0, "reference_range_m": 1e6, "range_quantum_m": 10.0, "pulse_quantum_m": 10.0,
    "echoes_max": 255,
}  # fmt: skip
"""Upper limits: an echo's number is a byte; the others are far beyond any LIDAR."""
_LEAST_STEP_DEG = 0.001
"""[deg] Lower limit, which keeps the number of beams countable; fine LIDARs have 0.05."""
_LEAST_REFERENCE_M = 0.001
"""[m] Lower limit, which keeps the threshold finite."""


@dataclass(frozen=True, slots=True)
class Fan:
    """Layers that fire at the same azimuths, in even steps from left to right (from high to low azimuth).

    A layer may be in several fans, for example if its step changes over the field of view.
    """

    layers: tuple[int, ...]
    start_deg: float
    """First azimuth in the unit's frame, left of the optical axis positive."""
    stop_deg: float
    """Last azimuth, a whole number of steps below `start_deg`."""
    step_deg: float
    """Step between azimuths, positive."""
    gain_percent: tuple[float, ...]
    """Sensitivity at the model's `gain_azimuth_deg`, percent of the centre's."""
    turn: int = 0
    """The fan fires in frames with index % turns == turn; `turns` is the model's."""
    tilt_deg: float = 0.0
    """Tilt of the mirror face, up positive; elevations change over azimuth, see `beams.beam_table`."""

    def __post_init__(self) -> None:
        if not self.layers:
            raise ValueError("layers = []: name at least one layer")
        if len(set(self.layers)) < len(self.layers):
            raise ValueError(f"layers = {list(self.layers)}: name each layer once")
        if self.step_deg < _LEAST_STEP_DEG:
            raise ValueError(f"step_deg = {self.step_deg}: must be at least {_LEAST_STEP_DEG}")
        if self.stop_deg > self.start_deg:
            raise ValueError(f"stop_deg = {self.stop_deg}: must not exceed start_deg; the sweep runs to the right")
        for key, azimuth in (("start_deg", self.start_deg), ("stop_deg", self.stop_deg)):
            if abs(azimuth) > 180.0:
                raise ValueError(f"{key} = {azimuth}: azimuths are from -180 to 180; split a fan that crosses the rear")
        if self.start_deg - self.stop_deg >= 360.0:
            raise ValueError(f"stop_deg = {self.stop_deg}: a fan covers less than a full turn; end one step earlier")
        steps = (self.start_deg - self.stop_deg) / self.step_deg
        if abs(steps - round(steps)) > _WHOLE_STEPS:
            raise ValueError(f"step_deg = {self.step_deg}: must divide start_deg - stop_deg into whole steps")
        if min(self.gain_percent, default=0.0) < 0.0:
            raise ValueError(f"gain_percent = {list(self.gain_percent)}: must not be negative")

    @property
    def count(self) -> int:
        """Beams of one layer."""
        return round((self.start_deg - self.stop_deg) / self.step_deg) + 1


@dataclass(frozen=True, slots=True)
class UnitModel:
    """LIDAR type. Its mirror or head rotates once per scan, at a constant rate, from left to right."""

    scan_rate_hz: float
    """Scans per second; the beam sweeps at 360 deg x scan_rate_hz."""
    range_min_m: float
    """Surfaces nearer than this block the beam and give no echo."""
    range_max_m: float
    beam_width_deg: float
    """Footprint of one beam over azimuth, edge to edge."""
    beam_height_deg: float
    """Footprint of one beam over elevation, edge to edge."""
    reference_reflectivity: float
    """Reflectivity of the weakest diffuse surface that gives an echo at `reference_range_m`, if it fills the footprint
    and faces a beam of gain 1. Received power is in reflectivity / m^2, so the detection threshold is
    reference_reflectivity / reference_range_m^2."""
    reference_range_m: float
    pulse_length_m: float
    """Returns within this difference in range are summed by the detector: c tau / 2 of a pulse of duration tau."""
    pulse_growth_m_per_db: float
    """Growth of the echo pulse width with the peak power relative to the threshold."""
    pulse_quantum_m: float
    """Step of the reported echo pulse width."""
    pulse_sigma_m: float
    """Standard deviation of a reported echo pulse width."""
    echoes_max: int
    """Echoes reported per beam, nearest first."""
    echo_separation_m: float
    """Echoes that start closer to each other than this are reported as one, at the nearer range."""
    range_sigma_m: float
    """Standard deviation of a reported range near the unit."""
    range_sigma_far_m: float
    """Standard deviation of a reported range at `reference_range_m` and beyond."""
    range_quantum_m: float
    """Step of the reported range."""
    layer_elevation_deg: tuple[float, ...]
    """Elevation of each layer's centre at azimuth 0, up positive, rising: layer 0 is the lowest."""
    layer_bias_m: tuple[float, ...]
    """Fixed range error of each layer."""
    layer_pulse_bias_m: tuple[float, ...]
    """Fixed error of the echo pulse width of each layer."""
    gain_azimuth_deg: tuple[float, ...]
    """Azimuths of the fans' `gain_percent`, falling; linear between them, constant beyond."""
    turns: int
    """Scans after which the firing pattern repeats: 2 for a mirror with two different faces, otherwise 1."""
    fans: tuple[Fan, ...]

    def __post_init__(self) -> None:
        layers = len(self.layer_elevation_deg)
        for key in _POSITIVE:
            if getattr(self, key) <= 0:
                raise ValueError(f"{key} = {getattr(self, key)}: must be positive")
        for key in _NOT_NEGATIVE:
            if getattr(self, key) < 0:
                raise ValueError(f"{key} = {getattr(self, key)}: must not be negative")
        for key, most in _AT_MOST.items():
            if getattr(self, key) > most:
                raise ValueError(f"{key} = {getattr(self, key)}: must be at most {most}")
        if self.reference_range_m < _LEAST_REFERENCE_M:
            raise ValueError(f"reference_range_m = {self.reference_range_m}: must be at least {_LEAST_REFERENCE_M}")
        if layers and max(map(abs, self.layer_elevation_deg)) + 0.5 * self.beam_height_deg > 90.0:
            raise ValueError(f"layer_elevation_deg = {list(self.layer_elevation_deg)}: beams may not pass 90 degrees")
        if self.range_min_m >= self.range_max_m:
            raise ValueError(f"range_min_m = {self.range_min_m}: must be below range_max_m")
        if not 0 < layers <= _MAX_LAYERS:
            raise ValueError(f"layer_elevation_deg has {layers} numbers: give 1 to {_MAX_LAYERS}, one per layer")
        if np.any(np.diff(self.layer_elevation_deg) <= 0.0):
            raise ValueError(
                f"layer_elevation_deg = {list(self.layer_elevation_deg)}: must rise; layer 0 is the lowest"
            )
        if self.range_sigma_far_m < self.range_sigma_m:
            raise ValueError(f"range_sigma_far_m = {self.range_sigma_far_m}: must be at least range_sigma_m")
        for key in ("layer_bias_m", "layer_pulse_bias_m"):
            if len(getattr(self, key)) != layers:
                raise ValueError(f"{key} = {list(getattr(self, key))}: give one number for each of {layers} layers")
        if not self.gain_azimuth_deg or np.any(np.diff(self.gain_azimuth_deg) >= 0.0):
            raise ValueError(f"gain_azimuth_deg = {list(self.gain_azimuth_deg)}: must fall from left to right")
        for fan in self.fans:
            self._check(fan)

    def _check(self, fan: Fan) -> None:
        layers = len(self.layer_elevation_deg)
        if not all(0 <= layer < layers for layer in fan.layers):
            raise ValueError(f"layers = {list(fan.layers)}: layer_elevation_deg has layers 0 to {layers - 1}")
        if len(fan.gain_percent) != len(self.gain_azimuth_deg):
            raise ValueError(f"gain_percent = {list(fan.gain_percent)}: give one number for each gain_azimuth_deg")
        if not 0 <= fan.turn < self.turns:
            raise ValueError(f"turn = {fan.turn}: must be 0 to {self.turns - 1}; turns = {self.turns}")
