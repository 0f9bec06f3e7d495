"""Small cars, sedans, estates, sport utility vehicles, pickups and vans.

Below the beltline they have bowed ends and sides, a hood, wheel arches and wheels, above it the upper body and mirrors.
"""

import math

from luxloop import elementary
from luxloop.sensor_model.bodies.materials import Glass
from luxloop.sensor_model.bodies.proportions import Draw, car_proportions
from luxloop.sensor_model.bodies.proportions.car_proportions import CarProportions
from luxloop.sensor_model.bodies.proportions.fitting_proportions import SPAN_END, SPAN_SIDE, Bow
from luxloop.sensor_model.bodies.shapes.cabin_shapes import Cabin, greenhouse
from luxloop.sensor_model.bodies.shapes.fitting_shapes import side_mirrors, wheels
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


_MIRROR_ROOT = 0.02
"""[m] Depth inside the widest line at which the mirrors' shells begin; their arms are left out."""
_SEAM = 0.002
"""[m] Excess of a load space's half width over the cab's."""
_CAB = 1.9
"""[m] Largest distance from the foot of a van's windscreen to the rear edge of its doors."""
_SCREEN = 0.85
"""[m] Largest height of a van's windscreen."""


_SMALL = 4.3
"""[m] Length below which a passenger car is a small hatchback."""
_ESTATES = 0.35
"""Share of estates and large hatchbacks among longer passenger cars; an estimate."""


def passenger_car(size: Vector, draw: Draw, glass: Glass) -> list[Solid]:
    """Make a small hatchback, a sedan or an estate, by length and by draw."""
    is_estate = draw(0.0, 1.0) < _ESTATES
    if size[0] < _SMALL:
        return two_box(size, car_proportions.small_car(draw), glass)
    if is_estate:
        return two_box(size, car_proportions.estate(draw), glass)
    return sedan(size, car_proportions.sedan(draw), glass)


_PICKUP = 5.2
"""[m] Length above which a high passenger car is a pickup: four labelled ones are 5.27 to 5.96 m long."""


def high_car(size: Vector, draw: Draw, glass: Glass) -> list[Solid]:
    """Make a sport utility vehicle or a pickup, by length."""
    if size[0] > _PICKUP:
        return sedan(size, car_proportions.pickup(draw), glass)
    return two_box(size, car_proportions.suv(draw), glass)


def sedan(size: Vector, p: CarProportions, glass: Glass) -> list[Solid]:
    """Make a three-box car or a pickup, glazed on all sides, with pillars between the doors."""
    return [*lower_body(size, p), *_glazed(size, p, glass, ((0.5, 0.10),)), *_mirrors(size, p)]


def two_box(size: Vector, p: CarProportions, glass: Glass) -> list[Solid]:
    """Make a hatchback, estate or sport utility vehicle, glazed, with pillars between and behind the doors."""
    return [*lower_body(size, p), *_glazed(size, p, glass, ((0.32, 0.12), (0.80, 0.12))), *_mirrors(size, p)]


def van(size: Vector, p: CarProportions, glass: Glass) -> list[Solid]:
    """Make a van: load space of sheet metal behind a glazed cab."""
    length, width, height = size
    cowl = length / 2 - p.hood_share * length
    screen_top = min(p.hood_rear + _SCREEN, height - 0.08)
    door = cowl - min(_CAB, 0.40 * length)
    half_width = width / 2 - p.glazing.shoulder
    cab = Cabin(
        (door, p.hood_rear), (cowl, p.hood_rear), half_width, screen_top, Part.BODY,
        front_bow=p.front_bow.glass, side_bow=p.side_bow,
    )  # fmt: skip
    # The load space begins at the cab's roof and slopes up to its own.
    front, belt = door + 0.3, p.hood_rear - 0.03
    tail = (height - belt) / elementary.tan(math.radians(p.glazing.backlight_deg))
    load = prism(
        Part.BODY,
        [
            (-length / 2, belt),
            (front, belt),
            (front, screen_top - 0.04),
            (front - 0.6 * (height - screen_top + 0.04), height),
            (tail - length / 2, height),
        ],
        half_width + _SEAM,
        [(belt, p.glazing.tumblehome_deg)],
    )
    top, rear, (left, right) = load.planes[3], load.planes[4], load.planes[-2:]
    flanks = [facet for side in (left, right) for facet in bowed(side, p.side_bow, SPAN_SIDE, SIDE_TANGENTS)]
    ends = bowed(rear, p.rear_bow.glass, SPAN_END, (-0.6, 0.6))
    rails = [bevel(Part.BODY, side, top, 0.12) for side in (left, right)]
    corners = [bevel(Part.BODY, rear, side, p.corner) for side in (left, right)]
    load = load.cut([*flanks, *ends, *rails, *corners]).pruned()
    return [*lower_body(size, p), *greenhouse(cab, p.glazing, glass), load, *_mirrors(size, p)]


def _glazed(size: Vector, p: CarProportions, glass: Glass, pillars: tuple[tuple[float, float], ...]) -> list[Solid]:
    """Make an upper body that is glazed on all sides."""
    length, width, height = size
    cabin = Cabin(
        rear_foot=(p.deck - length / 2, p.deck_height),
        front_foot=(length / 2 - p.hood_share * length, p.hood_rear),
        half_width=width / 2 - p.glazing.shoulder,
        roof=height,
        front_bow=p.front_bow.glass,
        rear_bow=p.rear_bow.glass,
        side_bow=p.side_bow,
    )
    return greenhouse(cabin, p.glazing, glass, pillars)


def _mirrors(size: Vector, p: CarProportions) -> list[Solid]:
    length, width, _ = size
    return side_mirrors(p.mirror, length, width / 2, _MIRROR_ROOT)
