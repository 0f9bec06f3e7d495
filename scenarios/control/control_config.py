"""What the cruise controller wants and may do. Light to import: scenario files are validated against it."""

from dataclasses import dataclass
from typing import Literal

_POSITIVE = (
    "set_speed_mps", "time_gap_s", "standstill_gap_m", "acceleration_mps2", "comfortable_deceleration_mps2",
    "corridor_half_width_m",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class CruiseConfig:
    """Adaptive cruise control by the Intelligent Driver Model; it steers nothing, the ego keeps its lane."""

    kind: Literal["cruise"]
    """The only controller there is."""
    set_speed_mps: float
    """[m/s] v0, driven where the road ahead is free."""
    time_gap_s: float = 1.6
    """[s] T, to the vehicle ahead in steady traffic; the model's authors' value."""
    standstill_gap_m: float = 2.0
    """[m] s0, bumper to bumper, to a vehicle that stands; the model's authors' value."""
    acceleration_mps2: float = 1.5
    """[m/s^2] a, the largest."""
    comfortable_deceleration_mps2: float = 2.0
    """[m/s^2] b, at which it brakes where nothing presses. ISO 15622 lets adaptive cruise control reach 3.5 to 5."""
    max_deceleration_mps2: float = 8.0
    """[m/s^2] at which it brakes at most, as an emergency brake does on a dry road."""
    corridor_half_width_m: float = 1.3
    """[m] Whoever reaches into the ego's path this far to either side of its middle is ahead. Half a car's width and
    0.35 m more; a car in the middle of the next lane of 3.2 m stays 1 m clear of it."""

    def __post_init__(self) -> None:
        for name in _POSITIVE:
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} = {getattr(self, name)} must be positive")
        if not self.max_deceleration_mps2 >= self.comfortable_deceleration_mps2:
            raise ValueError(
                f"max_deceleration_mps2 = {self.max_deceleration_mps2} must be no less than "
                f"comfortable_deceleration_mps2 = {self.comfortable_deceleration_mps2}"
            )
