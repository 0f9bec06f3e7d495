"""Cars and vans below the beltline: bowed ends and sides, hood, wheel arches and wheels."""

from luxloop.sensor_model.bodies.proportions.car_proportions import CarProportions
from luxloop.sensor_model.bodies.proportions.fitting_proportions import SPAN_END, SPAN_SIDE, Bow
from luxloop.sensor_model.bodies.shapes.fitting_shapes import wheels
from luxloop.sensor_model.bodies.solids import Plane, Solid, Vector, bevel, bowed, box, level, prism
from luxloop.sensor_model.truth import Part

SIDE_TANGENTS = (-1.2, 1.2)
"""[m] Tangents of bowed sides from their middle, beside that in the middle."""
_CHIN = 0.20
"""[m] Setback of the bumpers' lower edges at the underbody."""
_TUCK_DEG, _LEAN_DEG = 5.0, 6.0
"""[deg] Inward lean of the sides below and above their widest line, which is at the top of the bumpers: scan lines
across real flanks lie 0.04 m apart at bumper height, and 0.2 m from a roof (medians of 89 and 54 vehicles)."""
_WHEEL_WIDTH = 0.21
"""[m]"""
_CREST = (0.35, 0.60)
"""Point of the hood's profile as shares of its length and rise: steep at first, so that the fenders are high."""
_ARCH_GAP = 0.04
"""[m] Gap between tyre and fender, in front of, behind and above the wheel."""
_WELL = 0.28
"""[m] Depth of the wheel wells, from the side of the vehicle."""
_OVERLAP = 0.005
"""[m] Overlap of the pieces below and above the arches."""


def lower_body(size: Vector, p: CarProportions) -> list[Solid]:
    """Make the body below the beltline in five pieces, and the wheels.

    The arches divide it: one piece above them, three between and beyond them, and the wells' inner walls.
    """
    length, width, _ = size
    whole = _without_arches(size, p)
    half_arch, top = p.wheel_radius + _ARCH_GAP, 2.0 * p.wheel_radius + _ARCH_GAP
    front_axle, rear_axle = length / 2 - p.front_overhang, p.rear_overhang - length / 2
    cuts = [
        [level(Part.BODY, top, up=False)],
        [_wall(front_axle + half_arch, -1.0)],
        [_wall(front_axle - half_arch, 1.0), _wall(rear_axle + half_arch, -1.0)],
        [_wall(rear_axle - half_arch, 1.0)],
    ]
    lid = level(Part.BODY, top + _OVERLAP)
    above, *below = [whole.cut(planes if n == 0 else [*planes, lid]).pruned() for n, planes in enumerate(cuts)]
    well = box(
        Part.WHEEL,
        (rear_axle - half_arch, front_axle + half_arch),
        (_WELL - width / 2, width / 2 - _WELL),
        (p.clearance, top + _OVERLAP),
    )
    wheels_at = []
    for axle in (front_axle, rear_axle):
        fender = width / 2 - p.side_bow * (axle / SPAN_SIDE) ** 2
        wheels_at += wheels(axle, p.wheel_radius, fender - p.wheel_inset, _WHEEL_WIDTH)
    return [above, *below, well, *wheels_at]


def _without_arches(size: Vector, p: CarProportions) -> Solid:
    length, width, _ = size
    front, rear = length / 2, -length / 2
    hood = p.hood_share * length - p.nose
    profile = [
        (rear + _CHIN, p.clearance),
        (front - _CHIN, p.clearance),
        (front, p.bumper_bottom),
        (front, p.bumper_top),
        (front - p.nose, p.hood_front),
        (front - p.nose - _CREST[0] * hood, p.hood_front + _CREST[1] * (p.hood_rear - p.hood_front)),
        (front - p.hood_share * length, p.hood_rear),
        (rear + p.tail, p.deck_height),
        (rear, p.bumper_top),
        (rear, p.bumper_bottom),
    ]
    body = prism(Part.BODY, profile, width / 2, [(p.bumper_top, -_TUCK_DEG), (p.bumper_top, _LEAN_DEG)])
    _, front_chin, front_bumper, *bonnet, _, boot, rear_bumper, rear_chin = body.planes[:10]
    flanks = body.planes[10:]
    fascia = _bowed_end(front_chin, front_bumper, tuple(bonnet), p.front_bow)
    fascia += _bowed_end(rear_chin, rear_bumper, (boot,), p.rear_bow)
    facets = [facet for flank in flanks for facet in bowed(flank, p.side_bow, SPAN_SIDE, SIDE_TANGENTS)]
    upper = flanks[2:]
    corners = [
        bevel(Part.BODY, end, side, p.corner)
        for end_plane, bow, t in ((front_bumper, p.front_bow, 1.2), (rear_bumper, p.rear_bow, -1.2))
        for side_plane, y in zip(upper, (0.75, -0.75), strict=True)
        for end in bowed(end_plane, bow.bumper, SPAN_END, (y,))
        for side in bowed(side_plane, p.side_bow, SPAN_SIDE, (t,))
    ]
    return body.cut([*fascia, *facets, *corners])


def _bowed_end(chin: Plane, bumper: Plane, upper: tuple[Plane, ...], bow: Bow) -> list[Plane]:
    """Return the facets of an end beside those in the middle, which are the planes of the profile."""
    facets = bowed(chin, bow.lower, SPAN_END, (-0.5, 0.5)) + bowed(bumper, bow.bumper, SPAN_END, _BUMPER_TANGENTS)
    return facets + [facet for plane in upper for facet in bowed(plane, bow.upper, SPAN_END, (-0.5, 0.5))]


_BUMPER_TANGENTS = (-0.75, -0.38, 0.38, 0.75)


def _wall(x: float, sign: float) -> Plane:
    """Return a vertical plane across the body: the half-space behind it for sign 1, in front of it for -1."""
    return Plane((sign, 0.0, 0.0), sign * x, Part.BODY)
