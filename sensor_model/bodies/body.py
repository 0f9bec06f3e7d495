"""Body of one actor: its convex solids, scaled to its size, in flat arrays, with outline and relief.

The outline is the convex hull of the solids in plan. The relief is what the solids leave out, such as grilles, lamps,
plates and badges: the surface deviates from the faces of the solids by a random height, constant over time in the frame
of the body: a sum of cosines sqrt(2 / n) sigma cos(k . p + phase) with random wave vectors k (spectral representation,
Shinozuka and Deodatis 1991).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from luxloop import elementary
from luxloop.arrays import Bools, Bytes, Floats, Ints
from luxloop.sensor_model.bodies.materials import Glass, plane_reflectivity, plane_transmission
from luxloop.sensor_model.bodies.proportions import Draw
from luxloop.sensor_model.bodies.shapes import SHAPES, divided_on_rails
from luxloop.sensor_model.bodies.solids import Solid, Vector
from luxloop.sensor_model.truth import Part
from luxloop.sim.world import Kind


@dataclass(frozen=True, slots=True)
class Appearance:
    """Appearance of an actor; with the options of the `BodyFactory` it determines the body."""

    name: str
    kind: Kind
    size: Vector
    """Length, width, height [m]."""
    paint: float
    """Diffuse reflectivity, 0 to 1."""


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """P solids and Q planes in the frame of their body; `Bodies` holds these fields for all actors."""

    bounds: Floats
    """(2, 3)"""
    planes_of_solid: Ints
    """(P,) number of planes of each solid."""
    solid_bounds: Floats
    """(P, 2, 3)"""
    solid_inner: Bools
    """(P,)"""
    solid_ahead: Ints
    """(P,)"""
    planes: Floats
    """(Q, 4)"""
    plane_part: Bytes
    """(Q,)"""
    plane_reflectivity: Floats
    """(Q,)"""
    plane_transmission: Floats
    """(Q,)"""
    plane_relief: Floats
    """(Q,)"""
    relief_waves: Floats
    """(WAVES, 4)"""
    outline: Floats
    """(E, 3)"""


def build(appearance: Appearance, draw: Draw, glass: Glass, *, mirrors: bool, as_prism: bool) -> Body:
    """Build the body of an actor.

    Parameters
    ----------
    draw
        Random draws for the proportions.
    glass
        Glass of the windows.
    mirrors
        If True, the body has side mirrors.
    as_prism
        If True, a bounding prism replaces the other solids; a vehicle with joints has one per section.
    """
    shape = SHAPES[appearance.kind]
    size = np.clip(appearance.size, shape.smallest, shape.largest)
    length, width, height = size.tolist()
    solids = shape.make((length, width, height), draw, glass)
    if as_prism:
        solids = [*shape.plain((length, width, height)), *(solid for solid in solids if solid.is_mirror)]
    if not mirrors:
        solids = [solid for solid in solids if not solid.is_mirror]
    solids = divided_on_rails(solids, appearance.kind, appearance.size[0], length)
    stretch = np.array(appearance.size) / size
    return _flat(solids, stretch, appearance.paint, glass, 0.0 if as_prism else shape.relief, waves(draw))


def _flat(
    solids: list[Solid], stretch: Floats, paint: float, glass: Glass, relief: float, relief_waves: Floats
) -> Body:
    """Flatten solids, scaled along the axes: planes n . p <= d become (n / stretch) . p <= d, normalised."""
    flat = [plane for solid in solids for plane in solid.planes]
    planes = np.array([(*plane.normal, plane.offset) for plane in flat])
    planes[:, :3] /= stretch
    planes /= np.sqrt((planes[:, :3] ** 2).sum(axis=1, keepdims=True))
    part = np.array([plane.part for plane in flat], dtype=np.uint8)
    low = np.array([solid.low for solid in solids]) * stretch
    high = np.array([solid.high for solid in solids]) * stretch
    return Body(
        bounds=np.array([low.min(axis=0), high.max(axis=0)]),
        planes_of_solid=np.array([len(solid.planes) for solid in solids], dtype=np.int64),
        solid_bounds=np.stack([low, high], axis=1),
        solid_inner=np.array([solid.inner for solid in solids]),
        solid_ahead=np.array([solid.ahead for solid in solids], dtype=np.int64),
        planes=planes,
        plane_part=part,
        plane_reflectivity=plane_reflectivity(part, paint, glass),
        plane_transmission=plane_transmission(part, glass),
        plane_relief=plane_relief(part, planes, relief),
        relief_waves=relief_waves,
        outline=outline(solids, stretch),
    )


def outline(solids: Sequence[Solid], stretch: Floats) -> Floats:
    """Return the (E, 3) edges of the outline: outward unit normals and offsets [m].

    Parameters
    ----------
    solids
        Solids of the body. Side mirrors and what is behind glass do not count.
    stretch
        (3,) factors of the solids' coordinates.
    """
    outer = [solid.corners()[:, :2] for solid in solids if not (solid.is_mirror or solid.inner)]
    edges = scipy.spatial.ConvexHull(np.concatenate(outer) * stretch[:2]).equations
    return np.column_stack([edges[:, :2], -edges[:, 2]])


WAVES = 8
_SHORTEST, _LONGEST = 0.12, 0.60
"""[m] Wavelengths: from a lamp's or a grille bar's size to that of a plate or a grille."""


def waves(draw: Draw) -> Floats:
    """Draw (WAVES, 4) wave vectors [rad/m], in the body's y-z plane, and phases [rad]."""
    rows = []
    for _ in range(WAVES):
        number, direction = 2.0 * math.pi / draw(_SHORTEST, _LONGEST), draw(0.0, math.pi)
        rows.append(
            (0.0, number * elementary.cos(direction), number * elementary.sin(direction), draw(0.0, 2.0 * math.pi))
        )
    return np.array(rows)


def plane_relief(part: Bytes, planes: Floats, depth: float) -> Floats:
    """Return the standard deviation (Q,) of the relief of planes [m]: `depth` on painted fronts and rears.

    It falls with the square of the cosine between the normal and the body's axis, so that sides are smooth.
    """
    return np.where(part == Part.BODY, depth * planes[:, 0] ** 2, 0.0)
