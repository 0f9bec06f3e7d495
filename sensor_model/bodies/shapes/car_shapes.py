"""Sedans, sport utility vehicles and vans: lower body, upper body above the beltline, wheels and mirrors."""

import math

from sensor_model.bodies.materials import Glass
from sensor_model.bodies.proportions.car_proportions import CarProportions
from sensor_model.bodies.shapes.fitting_shapes import greenhouse, side_mirrors, side_pillar, wheels
from sensor_model.bodies.solids import Solid, Vector, bevel, prism, rounded
from sensor_model.truth import Part

_CHIN = 0.20
"""[m] Setback of the bumpers' lower edges at the underbody."""
_TUCK_DEG, _LEAN_DEG = 5.0, 3.0
"""[deg] Inward lean of the sides below and above their widest line, which is at the top of the bumpers."""
_WHEEL_WIDTH = 0.21
"""[m]"""
_WHEEL_INSET = 0.012
"""[m] Inset of the tyres' outer faces; below the widest line they protrude from the sides."""
_MIRROR_ROOT = 0.06
"""[m] Depth of the mirrors' roots, enough to reach the leaning side windows."""
_SEAM = 0.002
"""[m] Excess of a load space's half width over the cab's."""
_CAB = 1.9
"""[m] Largest distance from the foot of a van's windscreen to the rear edge of its doors."""
_SCREEN = 0.85
"""[m] Largest height of a van's windscreen."""


def sedan(size: Vector, p: CarProportions, glass: Glass) -> list[Solid]:
    """Make a three-box car, glazed on all sides, with pillars between the doors."""
    above = _glazed(size, p, glass)
    return [_lower_body(size, p), *above, side_pillar(above[0], 0.5, 0.10), *_fittings(size, p)]


def suv(size: Vector, p: CarProportions, glass: Glass) -> list[Solid]:
    """Make a two-box car, glazed on all sides, with pillars between and behind the doors."""
    above = _glazed(size, p, glass)
    pillars = [side_pillar(above[0], share, 0.12) for share in (0.32, 0.80)]
    return [_lower_body(size, p), *above, *pillars, *_fittings(size, p)]


def van(size: Vector, p: CarProportions, glass: Glass) -> list[Solid]:
    """Make a van: load space of sheet metal behind a glazed cab."""
    length, width, height = size
    cowl = length / 2 - p.hood_share * length
    screen_top = min(p.hood_rear + _SCREEN, height - 0.08)
    door = cowl - min(_CAB, 0.40 * length)
    half_width = width / 2 - p.glazing.shoulder
    cab = greenhouse(p.glazing, glass, (door, p.hood_rear), (cowl, p.hood_rear), half_width, screen_top, Part.BODY)
    # The load space begins at the cab's roof and slopes up to its own.
    front, belt = door + 0.3, p.hood_rear - 0.03
    tail = (height - belt) / math.tan(math.radians(p.glazing.backlight_deg))
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
    top, (left, right) = load.planes[3], load.planes[-2:]
    rails = [bevel(Part.BODY, side, top, 0.12) for side in (left, right)]
    load = load.cut([*rails, *rounded(Part.BODY, -length / 2, half_width, p.rear_radius)])
    return [_lower_body(size, p), *cab, load, *_fittings(size, p)]


def _lower_body(size: Vector, p: CarProportions) -> Solid:
    length, width, _ = size
    front, rear = length / 2, -length / 2
    profile = [
        (rear + _CHIN, p.clearance),
        (front - _CHIN, p.clearance),
        (front, p.bumper_bottom),
        (front, p.bumper_top),
        (front - p.nose, p.hood_front),
        (front - p.hood_share * length, p.hood_rear),
        (rear + p.tail, p.deck_height),
        (rear, p.bumper_top),
        (rear, p.bumper_bottom),
    ]
    body = prism(Part.BODY, profile, width / 2, [(p.bumper_top, -_TUCK_DEG), (p.bumper_top, _LEAN_DEG)])
    return body.cut(
        [
            *rounded(Part.BODY, front, width / 2, p.front_radius),
            *rounded(Part.BODY, rear, width / 2, p.rear_radius),
        ]
    )


def _glazed(size: Vector, p: CarProportions, glass: Glass) -> list[Solid]:
    """Make an upper body that is glazed on all sides."""
    length, width, height = size
    rear_foot = (p.deck - length / 2, p.deck_height)
    front_foot = (length / 2 - p.hood_share * length, p.hood_rear)
    return greenhouse(p.glazing, glass, rear_foot, front_foot, width / 2 - p.glazing.shoulder, height)


def _fittings(size: Vector, p: CarProportions) -> list[Solid]:
    """Make side mirrors and wheels."""
    length, width, _ = size
    outer = width / 2 - _WHEEL_INSET
    return [
        *side_mirrors(p.mirror, length, width / 2, _MIRROR_ROOT),
        *wheels(length / 2 - p.front_overhang, p.wheel_radius, outer, _WHEEL_WIDTH),
        *wheels(p.rear_overhang - length / 2, p.wheel_radius, outer, _WHEEL_WIDTH),
    ]
