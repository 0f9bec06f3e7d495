"""Configuration of all kinds of noise: the `[noise]` table of a scenario file."""

from dataclasses import dataclass, field

from sensor_model.noise.attitude import AttitudeNoise
from sensor_model.noise.calibration import CalibrationError
from sensor_model.noise.dirt import Dirt, DirtSector
from sensor_model.noise.dropout import Dropout
from sensor_model.noise.false_alarms import FalseAlarms
from sensor_model.noise.ghosts import Ghost
from sensor_model.noise.odometry_drift import OdometryNoise
from sensor_model.noise.outage import FixedOutage, Outage
from sensor_model.noise.outliers import Outliers
from sensor_model.noise.rain import Rain
from sensor_model.noise.range_error import RangeNoise
from sensor_model.noise.spray import Spray
from sensor_model.noise.sun import Sun

__all__ = [
    "AttitudeNoise",
    "CalibrationError",
    "Dirt",
    "DirtSector",
    "Dropout",
    "FalseAlarms",
    "FixedOutage",
    "Ghost",
    "LayerOverlap",
    "MirrorNoise",
    "NoiseConfig",
    "OdometryNoise",
    "Outage",
    "Outliers",
    "Rain",
    "RangeNoise",
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


@dataclass(frozen=True, slots=True)
class NoiseConfig:
    """All kinds of noise. The defaults represent a healthy rig on a dry, overcast day and a smooth road."""

    range: RangeNoise = field(default_factory=RangeNoise)
    dropout: Dropout = field(default_factory=Dropout)
    outage: Outage = field(default_factory=Outage)
    dirt: Dirt = field(default_factory=Dirt)
    sun: Sun = field(default_factory=Sun)
    mirror: MirrorNoise = field(default_factory=MirrorNoise)
    ghost: Ghost = field(default_factory=Ghost)
    layer_overlap: LayerOverlap = field(default_factory=LayerOverlap)
    calibration: CalibrationError = field(default_factory=CalibrationError)
    attitude: AttitudeNoise = field(default_factory=AttitudeNoise)
    odometry: OdometryNoise = field(default_factory=OdometryNoise)
    outliers: Outliers = field(default_factory=Outliers)
    false_alarms: FalseAlarms = field(default_factory=FalseAlarms)
    rain: Rain = field(default_factory=Rain)
    spray: Spray = field(default_factory=Spray)
