"""Configuration of highway-env traffic."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from luxloop.sim.modes import ModeLimits
from luxloop.sim.physical.physical_config import PhysicalConfig
from luxloop.sim.source import TrafficSource

_LARGEST = 10_000
"""Maximum of numbers in an environment's configuration: more lanes or vehicles take minutes to build."""

MOTORIST = "luxloop.sim.highway.motorist.Motorist"
"""Drivers within the limits of cars, as a value of `other_vehicles_type`."""

SMOOTHING_S = 0.32
"""[s] highway-env steers and brakes without delay: rates jump, but poses do not."""


@dataclass(frozen=True, slots=True)
class HighwayTraffic:
    """highway-env traffic. The end of an episode is ignored: a run ends with the scenario, or when the ego crashes."""

    kind: Literal["highway-env"] = "highway-env"
    env: str = "highway-v0"
    """Id of any environment that highway-env registers. The ego is its first agent; further agents get drivers of the
    same class as the other vehicles."""
    config: dict[str, Any] = field(default_factory=dict)
    """Overrides of the environment's configuration, by its keys. The drivers of highway-env turn more sharply than cars
    can; `other_vehicles_type = "luxloop.sim.highway.motorist.Motorist"` selects drivers that respect such limits."""
    ego: Literal["idm", "fixed", "controlled"] = "idm"
    """`idm`: a driver of the same class as the others, by IDM and MOBIL; on a car park, which has no road to follow,
    the ego stands. `fixed`: the ego repeats `action`, and soon crashes. `controlled`: it repeats the last commanded
    action, and idles before the first; follow a lane change by IDLE, else the ego continues to change lanes."""
    action: int | list[float] = 1
    """Action of the environment with `fixed`: the index of a discrete action (1 is IDLE), or the list of values of a
    continuous action, from -1 to 1: throttle, then steering, positive to the right; some environments take only one of
    the two."""
    redraw_default_sizes: bool = True
    """Replace highway-env's cars of 5 m by 2 m, except the ego, by cars of random size, drawn by the seed: no longer
    and no wider, about the same centre."""
    physical: PhysicalConfig | None = None
    """Smoothing of the motions. Default: over 0.32 s with the same look-ahead; without look-ahead if the ego is
    `controlled`."""
    modes: ModeLimits = field(default_factory=ModeLimits)
    """Limits of the motion modes."""
    suspension: bool = True
    """If true, bodies pitch and roll by their accelerations, and riders lean into turns."""

    def __post_init__(self) -> None:
        for key, value in self.config.items():
            if isinstance(value, int | float) and abs(value) > _LARGEST:
                raise ValueError(f"config.{key} = {value} must not exceed {_LARGEST}, which takes too long to build")
        for key in ("simulation_frequency", "policy_frequency"):
            if key in self.config:
                raise ValueError(f"config.{key} is fixed by the rig's 12.5 Hz; remove it")
        if self.ego == "controlled" and self.smoothing.lookahead_s > 0:
            raise ValueError(
                'physical.lookahead_s must be 0 with ego = "controlled": commands cannot reach a simulator ahead'
            )

    @property
    def smoothing(self) -> PhysicalConfig:
        """`physical`, or its default."""
        if self.physical is not None:
            return self.physical
        return PhysicalConfig(SMOOTHING_S, lookahead_s=0.0 if self.ego == "controlled" else SMOOTHING_S)

    def make_source(self, folder: Path, range_m: float) -> TrafficSource:
        """Make the source. See `luxloop.sim.factory.TrafficConfig`."""
        from luxloop.sim.highway.highway_source import HighwaySource

        return HighwaySource(self, folder, range_m)
