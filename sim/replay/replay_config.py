"""Configuration of recorded traffic."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from luxloop.sim.modes import ModeLimits
from luxloop.sim.physical.physical_config import PhysicalConfig
from luxloop.sim.replay.recording import ReplayType
from luxloop.sim.scripted.script import ScriptedObstacle
from luxloop.sim.source import TrafficSource

ENDINGS = (".csv", ".csv.gz", ".parquet", ".xml", ".xml.gz")


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplayTraffic:
    """Recorded traffic: a table, SUMO's floating car data, or CommonRoad XML."""

    kind: Literal["replay"] = "replay"
    file: str
    """Path of the recording, relative to the scenario file: `.csv`, `.csv.gz`, `.parquet`, `.xml` or `.xml.gz`."""
    ego: str
    """Id of the vehicle in the recording that carries the rig. The run ends where its samples end."""
    begin_s: float | None = None
    """[s] Time of frame 0 on the recording's clock; defaults to the ego's first sample."""
    dt_s: float = 0.08
    """[s] Time between frames; the rig turns at 12.5 Hz. The recording may have any sample rate."""
    gap_s: float = 1.0
    """[s] A road user is absent between samples that are further apart, and returns as a new actor."""
    types: dict[str, ReplayType] = field(default_factory=dict)
    """Meaning of the recording's names for types: SUMO's vehicle types, or values of a table's column `kind`."""
    obstacle: list[ScriptedObstacle] = field(default_factory=list)
    """Static obstacles, in the recording's coordinates."""
    physical: PhysicalConfig = field(default_factory=lambda: PhysicalConfig(smoothing_s=0.8, lookahead_s=2.6))
    """Physical truth layer, which converts samples to feasible motions. Defaults: `smoothing_s = 0.8` and
    `lookahead_s = 2.6`, sufficient for position noise of 5 cm. 0.24 s are sufficient for clean data, such as another
    simulator's."""
    modes: ModeLimits = field(default_factory=ModeLimits)
    """Limits of the true motion modes."""
    suspension: bool = True
    """If true, bodies pitch and roll by their accelerations, and riders lean into turns."""

    def __post_init__(self) -> None:
        if not self.file.endswith(ENDINGS):
            raise ValueError(f'file = "{self.file}" should end in {", ".join(ENDINGS)}')
        if not (self.dt_s > 0 and self.gap_s > 0):
            raise ValueError("dt_s and gap_s must be positive")

    def make_source(self, folder: Path, range_m: float) -> TrafficSource:
        """Make the source. See `luxloop.sim.factory.TrafficConfig`."""
        from luxloop.sim.replay.replay_source import ReplaySource

        return ReplaySource(self, folder, range_m)
