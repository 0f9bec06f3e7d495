"""Configuration of traffic by an OpenSCENARIO file."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from luxloop.sim.modes import ModeLimits
from luxloop.sim.physical.physical_config import PhysicalConfig
from luxloop.sim.source import TrafficSource


@dataclass(frozen=True, slots=True, kw_only=True)
class OpenScenarioTraffic:
    """Traffic by an ASAM OpenSCENARIO XML 1.x file: its entities follow the storyboard along lanes of OpenDRIVE."""

    kind: Literal["openscenario"] = "openscenario"
    file: str
    """Path of the `.xosc`, relative to the scenario file. It names the `.xodr` and the catalogs."""
    ego: str
    """Name of the entity that carries the rig. The run ends where it leaves the road, or by the file's StopTrigger."""
    parameters: dict[str, str] = field(default_factory=dict)
    """Values of parameters that the file declares, in place of its own."""
    dt_s: float = 0.08
    """[s] Time between frames; the rig turns at 12.5 Hz."""
    step_s: float = 0.01
    """[s] Longest step of the storyboard: conditions are tested and entities moved this often."""
    physical: PhysicalConfig = field(default_factory=lambda: PhysicalConfig(smoothing_s=0.4, lookahead_s=1.6))
    """Physical truth layer, which converts the storyboard's poses to feasible motions. Defaults: `smoothing_s = 0.4`
    and `lookahead_s = 1.6`."""
    modes: ModeLimits = field(default_factory=ModeLimits)
    """Limits of the true motion modes."""
    suspension: bool = True
    """If true, bodies pitch and roll by their accelerations, and riders lean into turns."""

    def __post_init__(self) -> None:
        if not self.file.endswith(".xosc"):
            raise ValueError(f'file = "{self.file}" should end in .xosc')
        if not 0.001 <= self.step_s <= self.dt_s:
            raise ValueError(f"step_s = {self.step_s} should be at least 0.001 s and at most dt_s = {self.dt_s}")

    def make_source(self, folder: Path, range_m: float) -> TrafficSource:
        """Make the source. See `luxloop.sim.factory.TrafficConfig`."""
        from luxloop.sim.openscenario.openscenario_source import OpenScenarioSource

        return OpenScenarioSource(self, folder, range_m)
