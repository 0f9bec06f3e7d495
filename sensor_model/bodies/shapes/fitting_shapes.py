"""Fittings shared by vehicles: wheels, side mirrors, and the glazed upper body with pillars and interior."""

from sensor_model.bodies.materials import Glass
from sensor_model.bodies.proportions.fitting_proportions import Glazing, MirrorBox
from sensor_model.bodies.solids import (
    HALF_FLAT,
    Plane,
    Solid,
    bevel,
    box,
    level,
    mirrored,
    moved,
    prism,
    sides,
    slope,
    x_at,
)
from sensor_model.truth import Part

_PROUD = 0.004
"""[m] Protrusion of pillars from the panes."""
_HEADROOM = 0.15
"""[m] Gap between the roof and the tops of seats and heads."""
_SUNK = 0.03
"""[m] Overlap of the glazed part with the body, which closes the gap."""
_LINING = 0.10
"""[m] Gap between the interior's walls, or the edge of a shelf, and the panes."""


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


def greenhouse(
    glazing: Glazing,
    glass: Glass,
    rear_foot: tuple[float, float],
    front_foot: tuple[float, float],
    half_width: float,
    roof: float,
    rear: Part = Part.GREENHOUSE,
) -> list[Solid]:
    """Make the glazed part of a vehicle and its interior.

    Roof, corner pillars, headers and rails are sheet metal: facets between the panes.

    Parameters
    ----------
    rear_foot, front_foot
        x, z [m] of the feet of rear window and windscreen; the latter is at the beltline.
    half_width
        Half width at the beltline [m].
    roof
        Height [m].
    rear
        Material of the rear window.
    """
    pane, metal, belt = Part.GREENHOUSE, Part.BODY, front_foot[1]
    back = slope(rear, *rear_foot, -glazing.backlight_deg)
    front = slope(pane, *front_foot, glazing.windscreen_deg)
    top, floor = level(metal, roof), level(metal, belt - _SUNK, up=False)
    left, right = sides(pane, half_width, belt, glazing.tumblehome_deg)
    pillars = [bevel(metal, front, side, glazing.front_pillar) for side in (left, right)]
    pillars += [bevel(metal, back, side, glazing.rear_pillar) for side in (left, right)]
    frame = [bevel(metal, plane, top, glazing.frame) for plane in (front, back, left, right)]
    low = (x_at(back, belt - _SUNK), -half_width - _SUNK, belt - _SUNK)
    high = (x_at(front, belt - _SUNK), half_width + _SUNK, roof)
    outside = Solid((front, back, left, right, top, floor, *pillars, *frame), low, high)
    return [outside, *_interior(outside, glass.interior_depth_m, belt)]


def side_pillar(greenhouse: Solid, share: float, width: float) -> Solid:
    """Make the pillars between two side windows: a slice of the greenhouse, a few millimetres wider.

    Parameters
    ----------
    share
        Position along the roof, 0 at its front edge to 1 at its rear edge.
    width
        [m] Width along the vehicle.
    """
    front, back, left, right, top, floor = greenhouse.planes[:6]
    rail = greenhouse.planes[-2]
    ahead, behind = x_at(front, top.offset), x_at(back, top.offset)
    x = ahead + share * (behind - ahead)
    # Height at which the side windows end under the rail.
    (_, y, z), offset = left.normal, left.offset
    z_end = (rail.offset * y - offset * rail.normal[1]) / (rail.normal[2] * y - z * rail.normal[1])
    low, high = (x - width / 2, greenhouse.low[1], greenhouse.low[2]), (x + width / 2, greenhouse.high[1], z_end)
    flats = [
        Plane((1.0, 0.0, 0.0), high[0], Part.BODY),
        Plane((-1.0, 0.0, 0.0), -low[0], Part.BODY),
        level(Part.BODY, z_end),
        moved(floor, 0.0, Part.BODY),
        moved(left, _PROUD, Part.BODY),
        moved(right, _PROUD, Part.BODY),
    ]
    return Solid(tuple(flats), low, high)


def _interior(greenhouse: Solid, depth: float, belt: float) -> list[Solid]:
    """Make seats and heads behind the panes, and dashboard and parcel shelf at the height of the beltline."""
    part = Part.INTERIOR
    front, back, left, right, top, floor = greenhouse.planes[:6]
    behind_back = depth if back.part is Part.GREENHOUSE else _LINING
    seats = [
        moved(front, -depth * front.normal[0], part),
        moved(back, behind_back * back.normal[0], part),
        moved(left, -0.5 * depth * left.normal[1], part),
        moved(right, 0.5 * depth * right.normal[1], part),
        moved(top, -_HEADROOM, part),
        moved(floor, 0.0, part),
    ]
    walls = [moved(plane, -_LINING, part) for plane in (front, back, left, right)]
    shelf = [*walls, level(part, belt - _SUNK / 3), moved(floor, 0.0, part)]
    return [Solid(tuple(planes), greenhouse.low, greenhouse.high, inner=True) for planes in (seats, shelf)]
