"""A road of an OpenDRIVE file, with positions along it and across it."""

from bisect import bisect_right
from dataclasses import dataclass

from luxloop import elementary
from luxloop.sim.opendrive.lanes import LaneSection, Steps, read_sections, read_steps
from luxloop.sim.opendrive.reference_line import Geometry, read_geometry
from luxloop.sim.xml_tree import XmlElement


@dataclass(frozen=True, slots=True)
class RoadEnd:
    """Link at one end of a road."""

    kind: str
    """`road` or `junction`."""
    id: str
    at_start: bool
    """The other road is entered at its start; unused for junctions."""


@dataclass(frozen=True, slots=True, eq=False)
class Road:
    """A road."""

    id: str
    length: float
    left_hand: bool
    """Traffic drives on the left."""
    geometries: list[Geometry]
    offset: Steps
    """[m] Offset of lane 0 to the left of the reference line."""
    sections: list[LaneSection]
    before: RoadEnd | None
    after: RoadEnd | None

    def section(self, s: float) -> LaneSection:
        """Return the lane section at a position [m]."""
        return self.sections[max(bisect_right(self.sections, s, key=lambda one: one.begin) - 1, 0)]

    def has_lane(self, s: float, lane: int) -> bool:
        """Return whether a lane exists at a position [m]."""
        return lane in self.section(s).lanes

    def centre(self, s: float, lane: int) -> float:
        """Return the centre [m] of a lane, to the left of the reference line; the lane must exist."""
        return self.offset.at(s) + sum(self.section(s).edges(s, lane)) / 2

    def lane_at(self, s: float, t: float) -> int | None:
        """Return the lane at a position [m] and offset [m] to the left of the reference line, or None beside it."""
        across = t - self.offset.at(s)
        section = self.section(s)
        for lane in sorted(section.lanes, key=abs):
            low, high = sorted(section.edges(s, lane))
            if low <= across <= high and high > low:
                return lane
        return None

    def forward(self, lane: int) -> int:
        """Return 1 if a lane drives along the reference line, -1 if against it."""
        return -1 if (lane > 0) != self.left_hand else 1

    def curvature(self, s: float) -> float:
        """Return the curvature [1/m] of the reference line."""
        geometry = self._geometry(s)
        return geometry.shape.bend(s - geometry.s)

    def pose(self, s: float, t: float) -> tuple[float, float, float, float]:
        """Return x [m], y [m], heading [rad] of the reference line and its curvature [1/m], at an offset t [m]."""
        x, y, heading, curvature = self._geometry(s).at(s)
        return x - t * elementary.sin(heading), y + t * elementary.cos(heading), heading, curvature

    def _geometry(self, s: float) -> Geometry:
        return self.geometries[max(bisect_right(self.geometries, s, key=lambda one: one.s) - 1, 0)]


def read_road(element: XmlElement) -> Road:
    """Read a `<road>`.

    Raises
    ------
    TrafficInputError
        A part of the road is missing or invalid.
    """
    length, lanes = element.number("length"), element.need("lanes")
    geometries = [read_geometry(one) for one in element.need("planView").all("geometry")]
    if not geometries or length <= 0:
        raise element.error("should have a positive length and at least one <geometry> in its <planView>")
    return Road(
        id=element.text("id"),
        length=length,
        left_hand=element.choice("rule", {"RHT": "", "LHT": "yes"}, "RHT") != "",
        geometries=sorted(geometries, key=lambda one: one.s),
        offset=read_steps(lanes.all("laneOffset"), "s"),
        sections=read_sections(lanes, length),
        before=_end(element.find("link", "predecessor")),
        after=_end(element.find("link", "successor")),
    )


def _end(element: XmlElement | None) -> RoadEnd | None:
    if element is None:
        return None
    kind = element.choice("elementType", {"road": "road", "junction": "junction"}, "road")
    at_start = element.choice("contactPoint", {"start": "yes", "end": ""}, "start") != ""
    return RoadEnd(kind, element.text("elementId"), at_start)
