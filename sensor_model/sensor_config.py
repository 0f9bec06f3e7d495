"""Configuration of the sensor simulation, apart from rig and noise."""

from dataclasses import dataclass, field

from luxloop.sensor_model.bodies.materials import Glass


@dataclass(frozen=True, slots=True)
class SensorConfig:
    """Sampling of the beams, and firing times."""

    footprint: tuple[int, int] = (9, 3)
    """Rays over the height and over the width of each beam, on an even grid. [1, 1] is one ray through the centre,
    which is fastest; the TU Darmstadt model of the LUX uses [41, 9]."""
    sweep: bool = True
    """If true, every beam fires at its own time while ego and actors move. If false, a scan is instantaneous."""
    glass: Glass = field(default_factory=Glass)
    """Glass of all vehicles."""
    relief_scale: float = 1.0
    """Factor of the relief of fronts and rears, such as grilles and lamps; 0 for smooth faces."""

    def __post_init__(self) -> None:
        if not all(1 <= count <= 99 for count in self.footprint):
            raise ValueError(f"footprint = {list(self.footprint)}: must be 1 to 99 rays over height and width")
        if not 0.0 <= self.relief_scale <= 5.0:
            raise ValueError(f"relief_scale = {self.relief_scale}: must be from 0 to 5; use 0 for smooth faces")
