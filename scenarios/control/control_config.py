"""Configuration of the cruise controller. Few imports: scenario files are validated against it."""

from dataclasses import dataclass
from typing import Literal

_POSITIVE = (
    "set_speed_mps", "time_gap_s", "standstill_gap_m", "acceleration_mps2", "comfortable_deceleration_mps2",
    "corridor_half_width_m",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class CruiseConfig:
    """Adaptive cruise control by the Intelligent Driver Model; longitudinal only, the ego keeps its lane."""

    kind: Literal["cruise"]
    """Kind of controller; only `cruise` exists."""
    set_speed_mps: float
    """[m/s] v0: speed on a free road."""
    time_gap_s: float = 1.6
    """[s] T: time gap to the lead vehicle in steady traffic; value of the model's authors."""
    standstill_gap_m: float = 2.0
    """[m] s0: bumper-to-bumper gap to a stationary lead vehicle; value of the model's authors."""
    acceleration_mps2: float = 1.5
    """[m/s^2] a: maximum acceleration."""
    comfortable_deceleration_mps2: float = 2.0
    """[m/s^2] b: deceleration in ordinary situations. ISO 15622 allows adaptive cruise control 3.5 to 5."""
    max_deceleration_mps2: float = 8.0
    """[m/s^2] Maximum deceleration, that of emergency braking on a dry road."""
    corridor_half_width_m: float = 1.3
    """[m] Half width of the corridor around the ego's path; the lead vehicle is the nearest one in it. The default is
    half a car's width plus 0.35 m; a car in the centre of the adjacent lane of 3.2 m is 1 m outside."""

    def __post_init__(self) -> None:
        for name in _POSITIVE:
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} = {getattr(self, name)} must be positive")
        if not self.max_deceleration_mps2 >= self.comfortable_deceleration_mps2:
            raise ValueError(
                f"max_deceleration_mps2 = {self.max_deceleration_mps2} must be at least "
                f"comfortable_deceleration_mps2 = {self.comfortable_deceleration_mps2}"
            )
