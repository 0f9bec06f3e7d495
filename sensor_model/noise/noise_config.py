"""Configuration of all kinds of noise: the `[noise]` table of a scenario file."""

from dataclasses import dataclass, field, fields, replace

from luxloop.sensor_model.noise.attitude import AttitudeNoise
from luxloop.sensor_model.noise.calibration import CalibrationError
from luxloop.sensor_model.noise.dirt import Dirt, DirtSector
from luxloop.sensor_model.noise.dropout import Dropout
from luxloop.sensor_model.noise.false_alarms import FalseAlarms
from luxloop.sensor_model.noise.fog import Fog
from luxloop.sensor_model.noise.ghosts import Ghost
from luxloop.sensor_model.noise.odometry_drift import OdometryNoise
from luxloop.sensor_model.noise.outage import FixedOutage, Outage
from luxloop.sensor_model.noise.outliers import Outliers
from luxloop.sensor_model.noise.rain import Rain
from luxloop.sensor_model.noise.range_error import RangeNoise
from luxloop.sensor_model.noise.snow import Snow
from luxloop.sensor_model.noise.spray import Spray
from luxloop.sensor_model.noise.sun import Sun

__all__ = [
    "KINDS",
    "AttitudeNoise",
    "CalibrationError",
    "Dirt",
    "DirtSector",
    "Dropout",
    "FalseAlarms",
    "FixedOutage",
    "Fog",
    "Ghost",
    "LayerOverlap",
    "MirrorNoise",
    "NoiseConfig",
    "OdometryNoise",
    "Outage",
    "Outliers",
    "Rain",
    "RangeNoise",
    "Snow",
    "Spray",
    "Sun",
]


@dataclass(frozen=True, slots=True)
class MirrorNoise:
    """Points on side mirrors, which protrude from the vehicle's outline."""

    enabled: bool = True
    """If false, vehicles have no side mirrors."""


@dataclass(frozen=True, slots=True)
class LayerOverlap:
    """Layers that hit a vehicle at different depths, such as bumper and rear window."""

    enabled: bool = True
    """If false, every body is its bounding prism from the ground to its height, so that all layers see the same
    outline; side mirrors stay."""


_HEALTHY_CALIBRATION = CalibrationError()
_HEALTHY_ATTITUDE = AttitudeNoise()
_HEALTHY_ODOMETRY = OdometryNoise()
"""Defaults of the car's errors. Their identity distinguishes a default from an equal table that was given."""


@dataclass(frozen=True, slots=True)
class NoiseConfig:
    """All kinds of noise. The defaults represent a healthy rig and car on a dry, overcast day and an ordinary road."""

    ideal: bool = False
    """If true, `calibration`, `attitude` and `odometry` are off, unless their tables are given: the mounts are exact,
    the ego is level and its odometry has no errors."""
    range: RangeNoise = field(default_factory=RangeNoise)
    dropout: Dropout = field(default_factory=Dropout)
    outage: Outage = field(default_factory=Outage)
    dirt: Dirt = field(default_factory=Dirt)
    sun: Sun = field(default_factory=Sun)
    mirror: MirrorNoise = field(default_factory=MirrorNoise)
    ghost: Ghost = field(default_factory=Ghost)
    layer_overlap: LayerOverlap = field(default_factory=LayerOverlap)
    calibration: CalibrationError = _HEALTHY_CALIBRATION
    attitude: AttitudeNoise = _HEALTHY_ATTITUDE
    odometry: OdometryNoise = _HEALTHY_ODOMETRY
    outliers: Outliers = field(default_factory=Outliers)
    false_alarms: FalseAlarms = field(default_factory=FalseAlarms)
    rain: Rain = field(default_factory=Rain)
    spray: Spray = field(default_factory=Spray)
    snow: Snow = field(default_factory=Snow)
    fog: Fog = field(default_factory=Fog)

    def __post_init__(self) -> None:
        if not self.ideal:
            return
        healthy = {
            "calibration": _HEALTHY_CALIBRATION, "attitude": _HEALTHY_ATTITUDE, "odometry": _HEALTHY_ODOMETRY,
        }  # fmt: skip
        for name, default in healthy.items():
            if getattr(self, name) is default:
                object.__setattr__(self, name, replace(default, enabled=False))


KINDS = tuple(kind.name for kind in fields(NoiseConfig) if kind.name != "ideal")
"""Names of all kinds of noise. The table of each has the switch `enabled`."""
