"""Reference line of a road: the geometries of OpenDRIVE's plan view (ASAM OpenDRIVE 1.8, section 9)."""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from luxloop import elementary, elementwise
from luxloop.arrays import Floats
from luxloop.sim.xml_tree import XmlElement

LINK_M = 0.1
"""[m] Step of the table that converts arc length to the parameter of a `poly3`."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)


class Shape(Protocol):
    """Curve that begins at the origin along the x axis."""

    def at(self, distance: float) -> tuple[float, float, float, float]:
        """Return x [m], y [m], heading [rad] and curvature [1/m] at an arc length [m]."""
        ...

    def bend(self, distance: float) -> float:
        """Return the curvature [1/m] alone, which is faster."""
        ...


@dataclass(frozen=True, slots=True)
class Clothoid:
    """Curve with linear curvature; lines and arcs are special cases."""

    curvature: float
    """[1/m] At the beginning."""
    slope: float = 0.0
    """[1/m^2] Change of curvature per arc length."""

    def at(self, distance: float) -> tuple[float, float, float, float]:
        """Integrate the direction by Gauss-Legendre quadrature, on parts that turn by less than 1 rad."""
        turn = abs(self.curvature * distance) + abs(self.slope) * distance**2 / 2
        edges = np.linspace(0.0, distance, min(int(turn), 1000) + 2)
        half = np.diff(edges)[:, None] / 2
        u = edges[:-1, None] + half * (1 + _NODES)
        heading = u * (self.curvature + self.slope * u / 2)
        x, y = (float((half * _WEIGHTS * part).sum()) for part in (elementwise.cos(heading), elementwise.sin(heading)))
        return x, y, distance * (self.curvature + self.slope * distance / 2), self.bend(distance)

    def bend(self, distance: float) -> float:
        """Return the curvature [1/m]."""
        return self.curvature + self.slope * distance


@dataclass(frozen=True, slots=True, eq=False)
class Cubics:
    """Curve with cubic polynomials for both coordinates."""

    u: Floats
    """(4,) Coefficients of x by power of the parameter."""
    v: Floats
    """(4,) The same for y."""
    length: Floats
    """(K,) [m] Arc lengths at which the parameter is known, ascending."""
    parameter: Floats
    """(K,) The parameter there."""

    def at(self, distance: float) -> tuple[float, float, float, float]:
        """Evaluate the polynomials and their derivatives."""
        p = float(np.interp(distance, self.length, self.parameter))
        powers = np.array([[1.0, p, p * p, p * p * p], [0.0, 1.0, 2 * p, 3 * p * p], [0.0, 0.0, 2.0, 6 * p]])
        (x, dx, ddx), (y, dy, ddy) = elementwise.product(powers, self.u), elementwise.product(powers, self.v)
        curvature = (dx * ddy - dy * ddx) / max(elementary.hypot(dx, dy), 1e-9) ** 3
        return float(x), float(y), elementary.atan2(dy, dx), float(curvature)

    def bend(self, distance: float) -> float:
        """Return the curvature [1/m]."""
        return self.at(distance)[3]


@dataclass(frozen=True, slots=True)
class Geometry:
    """A geometry of a plan view."""

    s: float
    """[m] Beginning, along the reference line."""
    x: float
    y: float
    heading: float
    """[rad] At the beginning, counter-clockwise from x."""
    shape: Shape

    def at(self, s: float) -> tuple[float, float, float, float]:
        """Return x [m], y [m], heading [rad] and curvature [1/m] at a position `s` [m] along the reference line."""
        x, y, heading, curvature = self.shape.at(s - self.s)
        cos, sin = elementary.cos(self.heading), elementary.sin(self.heading)
        return self.x + cos * x - sin * y, self.y + sin * x + cos * y, self.heading + heading, curvature


def read_geometry(element: XmlElement) -> Geometry:
    """Read a `<geometry>`.

    Raises
    ------
    TrafficInputError
        The geometry is of an unknown kind, or a number is missing.
    """
    length = element.number("length")
    if length < 0:
        raise element.error(f"length = {length:g} should not be negative")
    s, x, y, heading = (element.number(name) for name in ("s", "x", "y", "hdg"))
    shapes = [child for child in element.children if child.tag != "userData"]
    if len(shapes) != 1:
        raise element.error("should have exactly one of line, arc, spiral, poly3 and paramPoly3")
    return Geometry(s, x, y, heading, _shape(shapes[0], length))


def _shape(element: XmlElement, length: float) -> Shape:
    match element.tag:
        case "line":
            return Clothoid(0.0)
        case "arc":
            return Clothoid(element.number("curvature"))
        case "spiral":
            start, end = element.number("curvStart"), element.number("curvEnd")
            return Clothoid(start, (end - start) / length if length else 0.0)
        case "paramPoly3":
            scaled = element.choice("pRange", {"arcLength": "", "normalized": "yes"}, "normalized")
            u, v = (np.array([element.number(f"{power}{axis}") for power in "abcd"]) for axis in "UV")
            return Cubics(u, v, np.array([0.0, length]), np.array([0.0, 1.0 if scaled else length]))
        case "poly3":
            v = np.array([element.number(power) for power in "abcd"])
            u = np.linspace(0.0, length, min(math.ceil(length / LINK_M), 100_000) + 2)
            along = np.append(
                0.0, np.cumsum(elementwise.hypot(np.diff(u), np.diff(np.polynomial.polynomial.polyval(u, v))))
            )
            return Cubics(np.array([0.0, 1.0, 0.0, 0.0]), v, along, u)
        case _:
            raise element.error("is no geometry; use line, arc, spiral, poly3 or paramPoly3")
