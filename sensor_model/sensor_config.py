"""How closely the sensor is simulated: what belongs to the simulation, not to the rig and not to its noise."""

from dataclasses import dataclass, field

from sensor_model.bodies.materials import Glass


@dataclass(frozen=True, slots=True)
class SensorConfig:
    """How beams are sampled, and when they fire."""

    footprint: tuple[int, int] = (9, 3)
    """Rays over the height and over the width of each beam, on an even grid. [1, 1] is a ray through its centre, for
    speed; [41, 9] is what the TU Darmstadt model of the LUX casts."""
    sweep: bool = True
    """Whether every beam fires at its own time while the ego and all others move. If not, a scan is an instant."""
    glass: Glass = field(default_factory=Glass)
    """The glass of all vehicles."""

    def __post_init__(self) -> None:
        if not all(1 <= count <= 99 for count in self.footprint):
            raise ValueError(f"footprint = {list(self.footprint)}: give 1 to 99 rays over height and width")
