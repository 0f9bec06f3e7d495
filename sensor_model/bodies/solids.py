"""Convex solids as sets of half-spaces, and their construction from side views and angles.

Body frame: x forward, y left, z up, metres, origin at the box centre on the ground.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import scipy

from luxloop import elementary, elementwise
from luxloop.arrays import Floats
from luxloop.sensor_model.truth import Part

Vector = tuple[float, float, float]
Profile = Sequence[tuple[float, float]]
"""Convex polygon of x, z [m] in a side view, counter-clockwise with x to the right and z up."""

HALF_FLAT = math.sqrt(2.0) - 1.0
"""Half the side of an octagon around the unit circle."""
UPRIGHT = ((0.0, 0.0),)
"""Vertical sides."""

_CLEAR = 0.005
"""[m] Distance of a point from all planes that makes it a good centre of the dual points."""
_RELAXATIONS = 20
"""Largest number of steps; bodies of vehicles take one or two."""

_FACETS = [(math.cos(angle), math.sin(angle)) for angle in (math.pi / 6, math.pi / 3)]
"""Normals of the facets that approximate a quarter circle: tangents, less than 4 % of the radius outside of it."""


class Plane(NamedTuple):
    """The half-space normal . point <= offset [m]; the normal has length one and points out of the solid."""

    normal: Vector
    offset: float
    part: Part


@dataclass(frozen=True, slots=True)
class Solid:
    """Intersection of half-spaces."""

    planes: tuple[Plane, ...]
    low: Vector
    """Lower corner of its bounding box [m]."""
    high: Vector
    """Upper corner of its bounding box [m]."""
    inner: bool = False
    """True if it is behind glass."""
    ahead: int = 0
    """Number of its section ahead of the one that defines the pose: 1 for a tractor, negative behind, see
    `luxloop.sim.sections`. It moves with its section."""

    @property
    def is_mirror(self) -> bool:
        """Return True for a side mirror."""
        return self.planes[0].part is Part.MIRROR

    def cut(self, planes: Iterable[Plane]) -> "Solid":
        """Intersect the solid with further half-spaces; its bounding box stays."""
        return replace(self, planes=(*self.planes, *planes))

    def corners(self) -> Floats:
        """Return the (C, 3) corners [m], repeated where more than three faces meet."""
        hull, centre = self._dual_hull()
        return centre + _dual_points(hull)

    def pruned(self) -> "Solid":
        """Drop the planes without a face, and fit the bounding box to the rest."""
        hull, centre = self._dual_hull()
        corners = centre + _dual_points(hull)
        low, high = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
        kept = tuple(self.planes[row] for row in sorted(hull.vertices.tolist()))
        return replace(self, planes=kept, low=tuple(low), high=tuple(high))

    def _dual_hull(self) -> tuple["scipy.spatial.ConvexHull", Floats]:
        """Return the convex hull of the planes' dual points, and the centre of the duality.

        A plane n . p <= d has the dual point n / (d - n . c) for a point c inside the solid. It has a face if that is a
        vertex of the convex hull of all dual points, and the faces of that hull are the corners of the solid.

        Raises
        ------
        ValueError
            The solid is empty.
        """
        normals = np.array([plane.normal for plane in self.planes])
        offsets = np.array([plane.offset for plane in self.planes])
        centre = 0.5 * np.add(self.low, self.high)
        if np.any(elementwise.product(normals, centre) > offsets - _CLEAR):
            centre = _inside(normals, offsets, centre)
        return scipy.spatial.ConvexHull(normals / (offsets - elementwise.product(normals, centre))[:, None]), centre


def prism(part: Part, profile: Profile, half_width: float, leans: Sequence[tuple[float, float]] = UPRIGHT) -> Solid:
    """Extrude a side view across the width, symmetric about y = 0.

    Parameters
    ----------
    half_width
        [m] Largest half width.
    leans
        For each plane on either side: the height at which y = half_width [m], and its inward lean from the vertical
        [deg].
    """
    x, z = zip(*profile, strict=True)
    edges = [_through(a, b, part) for a, b in zip(profile, [*profile[1:], profile[0]], strict=True)]
    flanks = [plane for height, lean_deg in leans for plane in sides(part, half_width, height, lean_deg)]
    return Solid((*edges, *flanks), (min(x), -half_width, min(z)), (max(x), half_width, max(z)))


def box(part: Part, x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> Solid:
    """Make a box from its limits along each axis [m]."""
    planes = []
    for axis, (low, high) in enumerate((x, y, z)):
        planes += [
            Plane(_axis(axis, -1.0), -low, part),
            Plane(_axis(axis, 1.0), high, part),
        ]
    return Solid(tuple(planes), (x[0], y[0], z[0]), (x[1], y[1], z[1]))


def mirrored(solid: Solid) -> Solid:
    """Return the solid mirrored to the other side of the body."""
    planes = [Plane((x, -y, z), offset, part) for (x, y, z), offset, part in solid.planes]
    (x0, y0, z0), (x1, y1, z1) = solid.low, solid.high
    return Solid(tuple(planes), (x0, -y1, z0), (x1, -y0, z1), solid.inner)


def slope(part: Part, x: float, z: float, angle_deg: float) -> Plane:
    """Return the plane through the line x, z [m] across the body, inclined by an angle [deg] to the horizontal.

    It faces forward up to 90 degrees, and rearward for negative angles.
    """
    angle = math.radians(angle_deg)
    normal = (elementary.sin(angle), 0.0, elementary.cos(angle))
    return Plane(normal, normal[0] * x + normal[2] * z, part)


def level(part: Part, z: float, *, up: bool = True) -> Plane:
    """Return a horizontal plane at a height [m]: the half-space below it if `up`, else above it."""
    sign = 1.0 if up else -1.0
    return Plane((0.0, 0.0, sign), sign * z, part)


def x_at(plane: Plane, z: float) -> float:
    """Return x of a plane across the body at a height [m]."""
    return (plane.offset - plane.normal[2] * z) / plane.normal[0]


def sides(part: Part, half_width: float, z: float, lean_deg: float) -> list[Plane]:
    """Return left and right plane through y = +-half_width at z [m], with an inward lean from the vertical [deg]."""
    lean = math.radians(lean_deg)
    cos, sin = elementary.cos(lean), elementary.sin(lean)
    return [Plane((0.0, side * cos, sin), half_width * cos + z * sin, part) for side in (1.0, -1.0)]


def bowed(plane: Plane, bow: float, half_span: float, tangents: Sequence[float]) -> list[Plane]:
    """Return tangent planes of a parabolic cylinder that touches a plane along the body's x or y axis.

    The plane n . p <= d becomes n . p + c t^2 <= d, with t along y for the ends of a body and along x for its sides.
    Its tangent at t1 is n . p + 2 c t1 t <= d + c t1^2.

    Parameters
    ----------
    plane
        Tangent in the middle; its normal is perpendicular to x or to y.
    bow, half_span
        [m] Sagitta of a horizontal section, over this distance to either side of the middle.
    tangents
        t1 [m] of the planes.
    """
    nx, ny, nz = plane.normal
    across = ny == 0.0
    curvature = bow * abs(nx if across else ny) / half_span**2
    planes = []
    for t in tangents:
        slope = 2.0 * curvature * t
        length = elementary.hypot(1.0, slope)
        normal = (nx, slope, nz) if across else (slope, ny, nz)
        offset = plane.offset + curvature * t * t
        planes.append(Plane((normal[0] / length, normal[1] / length, normal[2] / length), offset / length, plane.part))
    return planes


def rounded(part: Part, x: float, half_width: float, radius: float) -> list[Plane]:
    """Return planes that round the vertical edges at x, y = +-half_width [m]; at the front for positive x."""
    length = abs(x)
    return [
        Plane(
            (math.copysign(cos, x), side * sin, 0.0),
            cos * (length - radius) + sin * (half_width - radius) + radius,
            part,
        )
        for side in (1.0, -1.0)
        for cos, sin in _FACETS
    ]


def bevel(part: Part, first: Plane, second: Plane, width: float) -> Plane:
    """Return the plane that bevels the edge of two planes symmetrically, with a strip of a width [m].

    The planes' normals are an angle t apart. The strip is the base of a triangle with equal legs and the angle pi - t
    between them, so it lies width / 2 tan(t / 2) deep.
    """
    total = [a + b for a, b in zip(first.normal, second.normal, strict=True)]
    length = math.sqrt(sum(component * component for component in total))
    half_angle = elementary.acos(min(0.5 * length, 1.0))
    offset = (first.offset + second.offset) / length - 0.5 * width * elementary.tan(half_angle)
    return Plane((total[0] / length, total[1] / length, total[2] / length), offset, part)


def moved(plane: Plane, distance: float, part: Part) -> Plane:
    """Return the plane shifted outwards [m], as another part."""
    return Plane(plane.normal, plane.offset + distance, part)


def _dual_points(hull: "scipy.spatial.ConvexHull") -> Floats:
    """Return the dual points of a hull's faces."""
    points: Floats = hull.equations[:, :3] / -hull.equations[:, 3:]
    return points


def _inside(normals: Floats, offsets: Floats, start: Floats) -> Floats:
    """Return a point clear of all planes n . p <= d: by relaxation, which is fast, else the centre of the largest ball.

    Each step moves the point over the plane that it violates most (Agmon 1954, "The relaxation method for linear
    inequalities", Canadian Journal of Mathematics 6).
    """
    point = start.copy()
    for _ in range(_RELAXATIONS):
        excess = elementwise.product(normals, point) - offsets + _CLEAR
        worst = int(excess.argmax())
        if excess[worst] <= 0.0:
            return point
        point -= (excess[worst] + 0.5 * _CLEAR) * normals[worst]
    return _ball_centre(normals, offsets)


def _ball_centre(normals: Floats, offsets: Floats) -> Floats:
    """Return the centre of the largest ball inside planes n . p <= d, by linear programming."""
    radius = [0.0, 0.0, 0.0, -1.0]
    limits = np.column_stack([normals, np.ones(len(normals))])
    found = scipy.optimize.linprog(radius, A_ub=limits, b_ub=offsets, bounds=[(None, None)] * 3 + [(0.0, None)])
    if not found.success or found.x[3] <= 0.0:
        raise ValueError("the half-spaces have no common interior")
    return np.asarray(found.x[:3])


def _through(a: tuple[float, float], b: tuple[float, float], part: Part) -> Plane:
    dx, dz = b[0] - a[0], b[1] - a[1]
    length = elementary.hypot(dx, dz)
    normal = (dz / length, 0.0, -dx / length)
    return Plane(normal, normal[0] * a[0] + normal[2] * a[1], part)


def _axis(axis: int, sign: float) -> Vector:
    return (sign * (axis == 0), sign * (axis == 1), sign * (axis == 2))
