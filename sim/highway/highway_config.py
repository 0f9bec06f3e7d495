"""What a scenario file says about traffic by highway-env."""

from dataclasses import dataclass, field
from typing import Any, Literal

from sim.modes import ModeLimits
from sim.physical.physical_config import PhysicalConfig

_LARGEST = 10_000
"""Of numbers in an environment's configuration: so many lanes or vehicles take minutes to be made."""

SMOOTHING_S = 0.32
"""[s] highway-env steers and brakes without delay: rates jump, but no pose does."""


@dataclass(frozen=True, slots=True)
class HighwayTraffic:
    """highway-env traffic. An episode's own end is ignored: the run ends with the scenario, or by the ego's crash."""

    kind: Literal["highway-env"] = "highway-env"
    env: str = "highway-v0"
    """Id of any environment that highway-env registers. The ego is its first agent; further agents get drivers
    as the other vehicles have."""
    config: dict[str, Any] = field(default_factory=dict)
    """Overrides of the environment's own configuration, by its keys. The drivers that highway-env comes with turn more
    sharply than cars can; `other_vehicles_type = "sim.highway.motorist.Motorist"` are some that do not."""
    ego: Literal["idm", "fixed", "controlled"] = "idm"
    """`idm`: a driver as the others have, by IDM and MOBIL; on a car park, which has no road to follow, the ego stands.
    `fixed`: it repeats `action`, and crashes soon. `controlled`: it repeats the last action it was commanded, and idles
    before the first; a lane change is to be followed by IDLE, else it goes on lane by lane."""
    action: int | list[float] = 1
    """Under `fixed`, one action of the environment: the index of a discrete one (1 is IDLE), or the list of a
    continuous one's values, from -1 to 1: throttle, then steering, to the right on the road; some environments take
    but one of them."""
    redraw_default_sizes: bool = True
    """Whether cars of highway-env's 5 m by 2 m, but for the ego, are drawn anew by the seed: no longer and no wider,
    about the same centre."""
    physical: PhysicalConfig | None = None
    """How motions are smoothed. Left out, over 0.32 s with as much look-ahead; without look-ahead if the ego is
    `controlled`."""
    modes: ModeLimits = field(default_factory=ModeLimits)
    """Limits of the motion modes."""

    def __post_init__(self) -> None:
        for key, value in self.config.items():
            if isinstance(value, int | float) and abs(value) > _LARGEST:
                raise ValueError(f"config.{key} = {value}: more than {_LARGEST} takes forever; give less")
        for key in ("simulation_frequency", "policy_frequency"):
            if key in self.config:
                raise ValueError(f"config.{key} is fixed by the rig's 12.5 Hz; leave it out")
        if self.ego == "controlled" and self.smoothing.lookahead_s > 0:
            raise ValueError(
                'physical.lookahead_s must be 0 with ego = "controlled": no command reaches a simulator that is ahead'
            )

    @property
    def smoothing(self) -> PhysicalConfig:
        """`physical`, or what stands for it."""
        if self.physical is not None:
            return self.physical
        return PhysicalConfig(SMOOTHING_S, lookahead_s=0.0 if self.ego == "controlled" else SMOOTHING_S)
