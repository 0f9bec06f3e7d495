"""Small cars, sedans, estates, sport utility vehicles, pickups and vans: upper body above the beltline, and mirrors.

`lower_body` has the body below the beltline, with the wheels.
"""

import math

from luxloop import elementary
from luxloop.sensor_model.bodies.materials import Glass
from luxloop.sensor_model.bodies.proportions import Draw, car_proportions
from luxloop.sensor_model.bodies.proportions.car_proportions import CarProportions
from luxloop.sensor_model.bodies.proportions.fitting_proportions import SPAN_END, SPAN_SIDE
from luxloop.sensor_model.bodies.shapes.cabin_shapes import Cabin, greenhouse
from luxloop.sensor_model.bodies.shapes.fitting_shapes import side_mirrors
from luxloop.sensor_model.bodies.shapes.lower_body import SIDE_TANGENTS, lower_body
from luxloop.sensor_model.bodies.solids import Solid, Vector, bevel, bowed, prism
from luxloop.sensor_model.truth import Part

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
