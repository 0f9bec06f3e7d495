"""Terrain of a SUMO net. libsumo gives lanes without heights, so they are read from the file."""

from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import BinaryIO
from xml.parsers import expat

import numpy as np

from luxloop.arrays import Floats
from luxloop.sim.input_files import DAMAGED, open_detected
from luxloop.sim.road_terrain import LaneSections, road_terrain
from luxloop.sim.source import TrafficInputError
from luxloop.sim.world import Terrain

_DEFAULT_WIDTH_M = 3.2  # SUMO's
_BLOCK = 2**20
_OUTLINED = ("walkingarea",)  # their lanes' shapes are outlines


def lane_sections(net: Path) -> LaneSections | None:
    """Return the sections of all lanes in the net's coordinates, None if all heights are 0.

    A net without heights costs one search through the file.

    Raises
    ------
    TrafficInputError
        The net cannot be read.
    """
    try:
        with open_detected(net) as stream:
            if not _mentions_heights(stream):
                return None
        with open_detected(net) as stream:
            lanes = _Lanes(stream)
    except TrafficInputError as error:
        raise TrafficInputError(f"{net.name}: {error}") from error
    except (*DAMAGED, expat.ExpatError, ValueError) as error:
        raise TrafficInputError(f"{net.name}: its lanes cannot be read: {error}; build the net again") from error
    ends = np.array(lanes.ends).reshape(-1, 2, 3)
    return LaneSections(ends, 0.5 * np.array(lanes.width)) if ends[..., 2].any() else None


def _mentions_heights(stream: BinaryIO) -> bool:
    """Return True if any element has an attribute z; netconvert writes it at junctions off height 0."""
    end = b""
    while block := stream.read(_BLOCK):
        if b' z="' in end + block or b" z='" in end + block:
            return True
        end = block[-3:]
    return False


class _Lanes:
    """Sections of the lanes of a stream of XML, as lists."""

    def __init__(self, stream: BinaryIO) -> None:
        self.ends: list[tuple[list[float], list[float]]] = []
        self.width: list[float] = []
        self._function = ""
        parser = expat.ParserCreate()
        parser.StartElementHandler = self._start
        parser.ParseFile(stream)

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        if tag == "edge":
            self._function = attributes.get("function", "")
        if tag != "lane" or self._function in _OUTLINED:
            return
        points = [[float(number) for number in point.split(",")] for point in attributes["shape"].split()]
        points = [[*point, 0.0][:3] for point in points]  # SUMO omits a height of 0
        width = float(attributes.get("width", _DEFAULT_WIDTH_M))
        self.ends += pairwise(points)
        self.width += [width] * (len(points) - 1)


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
