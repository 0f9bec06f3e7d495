"""Terrain of a SUMO net."""

from dataclasses import dataclass, replace
from pathlib import Path

from luxloop.arrays import Floats
from luxloop.sim.road_terrain import road_terrain
from luxloop.sim.sumo.lane_heights import lane_sections
from luxloop.sim.world import Terrain

BRIDGES = (
    "the net has roads above one another: bridges have no surface, so beams pass through them and hit the lower road; "
    "choose an ego that drives away from them"
)
"""Warning about a net with bridges."""


@dataclass(frozen=True, slots=True, eq=False)
class NetTerrain:
    """Terrain of a net."""

    terrain: Terrain | None
    """In the net's coordinates; None if the net is flat."""
    bridges: bool
    """True if a road passes above another."""

    @property
    def warnings(self) -> tuple[str, ...]:
        """Defects of the terrain, one line each."""
        return (BRIDGES,) if self.bridges else ()

    def seen_from(self, origin: Floats) -> Terrain | None:
        """Return the terrain in the world frame with an origin (2,) in the net's coordinates [m]."""
        if self.terrain is None:
            return None
        return replace(self.terrain, corner_world=self.terrain.corner_world - origin)


def net_terrain(net: Path) -> NetTerrain:
    """Return the terrain of a net."""
    sections = lane_sections(net)
    if sections is None:
        return NetTerrain(None, bridges=False)
    terrain, above = road_terrain(sections)
    return NetTerrain(terrain, bridges=above > 0)
