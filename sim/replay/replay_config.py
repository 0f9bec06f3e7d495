"""What a scenario file says of recorded traffic."""

from dataclasses import dataclass, field
from typing import Literal

from sim.modes import ModeLimits
from sim.physical.physical_config import PhysicalConfig
from sim.replay.recording import ReplayType
from sim.scripted.script import ScriptedObstacle

ENDINGS = (".csv", ".csv.gz", ".parquet", ".xml", ".xml.gz")


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplayTraffic:
    """Recorded traffic: a table, SUMO's floating car data, or CommonRoad XML."""

    kind: Literal["replay"] = "replay"
    file: str
    """Path of the recording, relative to the scenario file: `.csv`, `.csv.gz`, `.parquet`, `.xml` or `.xml.gz`."""
    ego: str
    """Id, in the recording, of the vehicle that carries the rig. The run ends where its samples end."""
    begin_s: float | None = None
    """[s] by the recording's clock, of frame 0; where the ego's samples begin, if left out."""
    dt_s: float = 0.08
    """[s] Time between frames; the rig turns at 12.5 Hz. The recording may have any sample rate."""
    gap_s: float = 1.0
    """[s] Between samples that are further apart a road user is absent, and comes back as another."""
    types: dict[str, ReplayType] = field(default_factory=dict)
    """What the recording's own words for types mean: SUMO's vehicle types, or words in a table's column `kind`."""
    obstacle: list[ScriptedObstacle] = field(default_factory=list)
    """What stands along the road, in the recording's coordinates."""
    physical: PhysicalConfig = field(default_factory=lambda: PhysicalConfig(smoothing_s=0.8, lookahead_s=2.6))
    """Of the layer that makes bodies of the samples. Without this table `smoothing_s = 0.8` and `lookahead_s = 2.6`:
    enough for positions that jitter by 5 cm. What is as clean as another simulator's may do with 0.24 s."""
    modes: ModeLimits = field(default_factory=ModeLimits)
    """Limits of the true motion modes."""

    def __post_init__(self) -> None:
        if not self.file.endswith(ENDINGS):
            raise ValueError(f'file = "{self.file}": should end in {", ".join(ENDINGS)}')
        if not (self.dt_s > 0 and self.gap_s > 0):
            raise ValueError("dt_s and gap_s must be positive")
