"""Fittings shared by vehicles: wheels and side mirrors."""

from luxloop.sensor_model.bodies.proportions.fitting_proportions import MirrorBox
from luxloop.sensor_model.bodies.solids import HALF_FLAT, Solid, box, mirrored, moved, prism, sides
from luxloop.sensor_model.truth import Part


def wheels(x: float, radius: float, outer: float, width: float) -> list[Solid]:
    """Make a wheel on either side: octagons in side view, without the two upper facets, which are inside the body.

    Parameters
    ----------
    outer, width
        [m] Distance of the outer faces from the middle, and width of a wheel.
    """
    flat = HALF_FLAT * radius
    ring = [(-flat, -radius), (flat, -radius), (radius, -flat), (radius, radius), (-radius, radius), (-radius, -flat)]
    centred = prism(Part.WHEEL, [(x + dx, radius + dz) for dx, dz in ring], outer)
    inner = moved(sides(Part.WHEEL, outer - width, 0.0, 0.0)[1], 2 * width - 2 * outer, Part.WHEEL)
    kept = (*centred.planes[:-1], inner)
    left = Solid(kept, (centred.low[0], outer - width, centred.low[2]), centred.high)
    return [left, mirrored(left)]


def side_mirrors(mirror: MirrorBox, length: float, half_width: float, root: float) -> list[Solid]:
    """Make a side mirror on either side.

    Parameters
    ----------
    length, half_width
        [m] Length and half width of the vehicle.
    root
        [m] Depth inside the vehicle's side at which the shells begin.
    """
    x, outer = mirror.x * length, half_width + mirror.protrusion
    left = box(
        Part.MIRROR,
        (x - mirror.length / 2, x + mirror.length / 2),
        (half_width - root, outer),
        (mirror.z - mirror.height / 2, mirror.z + mirror.height / 2),
    )
    return [left, mirrored(left)]
