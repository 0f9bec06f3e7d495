"""Lanes of a road: sections, widths and the offset of lane 0."""

from bisect import bisect_right
from dataclasses import dataclass

from luxloop.sim.xml_tree import XmlElement


@dataclass(frozen=True, slots=True)
class Steps:
    """Piecewise cubic polynomial of the position along a road."""

    begin: tuple[float, ...]
    """[m] Beginnings of the pieces, ascending."""
    coefficients: tuple[tuple[float, ...], ...]
    """Coefficients a, b, c, d of each piece, by power of the distance from its beginning."""

    def at(self, s: float) -> float:
        """Return the value at a position; 0 before the first piece."""
        piece = bisect_right(self.begin, s) - 1
        if piece < 0:
            return 0.0
        a, b, c, d = self.coefficients[piece]
        x = s - self.begin[piece]
        return a + x * (b + x * (c + x * d))


@dataclass(frozen=True, slots=True)
class Lane:
    """A lane of a section. Negative ids are to the right of lane 0, which has no width."""

    id: int
    width: Steps
    """[m] By distance from the beginning of the section."""
    predecessor: int | None
    successor: int | None


@dataclass(frozen=True, slots=True)
class LaneSection:
    """Lanes of a part of a road."""

    begin: float
    end: float
    """[m] Part of the road, along its reference line."""
    lanes: dict[int, Lane]

    def follower(self, lane: int, forward: int) -> int | None:
        """Return the linked lane behind the end (`forward` 1) or before the beginning (-1), None without a link."""
        one = self.lanes.get(lane)
        return None if one is None else one.successor if forward > 0 else one.predecessor

    def edges(self, s: float, lane: int) -> tuple[float, float]:
        """Return the inner and outer edge [m] of a lane, to the left of lane 0; the lane must exist."""
        side, edge, inner = (1 if lane > 0 else -1), 0.0, 0.0
        for number in range(side, lane + side, side):
            width = self.lanes[number].width.at(s - self.begin) if number in self.lanes else 0.0
            inner, edge = edge, edge + side * max(width, 0.0)
        return inner, edge


def read_steps(elements: list[XmlElement], start: str) -> Steps:
    """Read pieces of polynomials, whose beginning is attribute `start`."""
    pieces = sorted((one.number(start), tuple(one.number(power) for power in "abcd")) for one in elements)
    return Steps(tuple(piece[0] for piece in pieces), tuple(piece[1] for piece in pieces))


def read_sections(element: XmlElement, length: float) -> list[LaneSection]:
    """Read the sections of a `<lanes>`, ordered along the road of a length [m].

    Raises
    ------
    TrafficInputError
        There is no section, or an entry of one is invalid.
    """
    found = sorted(((one.number("s"), n) for n, one in enumerate(element.all("laneSection"))), key=lambda key: key[0])
    if not found:
        raise element.error("has no <laneSection>; add one")
    ends = [*(begin for begin, _ in found[1:]), length]
    sections = element.all("laneSection")
    return [LaneSection(begin, end, _lanes(sections[n])) for (begin, n), end in zip(found, ends, strict=True)]


def _lanes(section: XmlElement) -> dict[int, Lane]:
    lanes = [one for side in ("left", "right") for group in section.all(side) for one in group.all("lane")]
    return {lane.id: lane for lane in map(_lane, lanes)}


def _lane(element: XmlElement) -> Lane:
    if element.all("border") and not element.all("width"):
        raise element.error("has borders, which are not supported; write widths")
    links = [element.find("link", side) for side in ("predecessor", "successor")]
    before, after = (link.whole("id") if link else None for link in links)
    return Lane(element.whole("id"), read_steps(element.all("width"), "sOffset"), before, after)
