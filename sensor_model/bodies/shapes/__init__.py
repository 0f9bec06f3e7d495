"""Shapes of the kinds of road users: construction of their solids, and their sizes."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from luxloop.sensor_model.bodies.materials import Glass
from luxloop.sensor_model.bodies.proportions import Draw, car_proportions, heavy_proportions, rider_proportions
from luxloop.sensor_model.bodies.shapes import car_shapes, heavy_shapes, rider_shapes
from luxloop.sensor_model.bodies.solids import Solid, Vector, box
from luxloop.sensor_model.truth import Part
from luxloop.sim.articulation import LONGEST_M, SHORTEST_M, hitch, is_articulated
from luxloop.sim.sections import is_on_rails, section_count
from luxloop.sim.world import Kind


def plain(size: Vector) -> list[Solid]:
    """Make the bounding prism from the ground to the top."""
    return [_prism(size, -size[0] / 2, size[0] / 2)]


def plain_articulated(size: Vector) -> list[Solid]:
    """Make bounding prisms of the tractor and of the trailer; without articulation they fill one box."""
    end = size[0] / 2
    trailer_front = end - float(hitch(np.array(size[:1])).trailer_front[0])
    return [_prism(size, -end, trailer_front), replace(_prism(size, trailer_front, end), ahead=1)]


def plain_bus(size: Vector) -> list[Solid]:
    """Make the bounding prism of a bus, divided at the joint of an articulated one."""
    return heavy_shapes.divided(plain(size), [heavy_shapes.bus_joint(size[0])]) if _bends(size) else plain(size)


def divided_on_rails(solids: list[Solid], kind: Kind, length: float, made_length: float) -> list[Solid]:
    """Divide the solids of a tram or train at its joints; return those of other kinds and lengths as they are.

    Parameters
    ----------
    length
        Overall length [m], which decides the number of sections.
    made_length
        Length of the solids before they are scaled to it [m].
    """
    kinds, lengths = np.array([kind], np.uint8), np.array([length])
    if not is_on_rails(kinds, lengths)[0]:
        return solids
    count = int(section_count(kinds, lengths)[0])
    return heavy_shapes.divided(solids, [made_length * (0.5 - k / count) for k in range(1, count)])


def _bus(size: Vector, draw: Draw, glass: Glass) -> list[Solid]:
    make = heavy_shapes.articulated_bus if _bends(size) else heavy_shapes.bus
    return make(size, heavy_proportions.bus(draw), glass)


def _bends(size: Vector) -> bool:
    return bool(is_articulated(np.array([Kind.BUS], np.uint8), np.array(size[:1]))[0])


def _prism(size: Vector, rear: float, front: float) -> Solid:
    return box(Part.BODY, (rear, front), (-size[1] / 2, size[1] / 2), (0.0, size[2]))


@dataclass(frozen=True, slots=True)
class Shape:
    """Shape of one kind of road user. Sizes are length, width and height [m]."""

    size: Vector
    """Typical size."""
    smallest: Vector
    largest: Vector
    """Between these sizes, angles and heights are those of the proportions. Other sizes are the nearest one, scaled."""
    make: Callable[[Vector, Draw, Glass], list[Solid]]
    """Constructor of the solids from size, draw of the proportions, and glass (interior depth)."""
    relief: float = 0.0
    """Depth of details on fronts and rears: standard deviation from the solids' faces [m]."""
    plain: Callable[[Vector], list[Solid]] = plain
    """Constructor of the bounding prisms."""


_CAR_RELIEF, _TRUCK_RELIEF = 0.035, 0.01
"""[m] Points of one scan line lie 2.3 to 3.8 cm about a parabola on real fronts and rears, with the noise of the unit
(medians of 55, 54 and 89 vehicles); the relief of cars is what noise and solids leave of it. That of
trucks is an estimate."""

SHAPES = {
    Kind.CAR: Shape(
        size=(4.70, 1.82, 1.46),
        smallest=(3.40, 1.50, 1.38),
        largest=(5.10, 2.00, 1.56),
        make=car_shapes.passenger_car,
        relief=_CAR_RELIEF,
    ),
    Kind.SUV: Shape(
        size=(4.60, 1.88, 1.70),
        smallest=(4.10, 1.70, 1.55),
        largest=(6.00, 2.05, 1.85),
        make=car_shapes.high_car,
        relief=_CAR_RELIEF,
    ),
    Kind.VAN: Shape(
        size=(5.50, 2.00, 2.30),
        smallest=(4.60, 1.80, 1.70),
        largest=(7.00, 2.20, 2.90),
        make=lambda size, draw, glass: car_shapes.van(size, car_proportions.van(draw), glass),
        relief=_CAR_RELIEF,
    ),
    Kind.TRUCK: Shape(
        size=(8.00, 2.50, 3.20),
        smallest=(6.50, 2.20, 2.40),
        largest=(12.00, 2.60, 4.00),
        make=lambda size, draw, glass: heavy_shapes.truck(size, heavy_proportions.truck(draw), glass),
        relief=_TRUCK_RELIEF,
    ),
    Kind.TRAILER_TRUCK: Shape(
        size=(16.50, 2.55, 4.00),
        smallest=(SHORTEST_M, 2.40, 3.20),
        largest=(LONGEST_M, 2.60, 4.30),
        make=lambda size, draw, glass: heavy_shapes.trailer_truck(size, heavy_proportions.trailer_truck(draw), glass),
        plain=plain_articulated,
        relief=_TRUCK_RELIEF,
    ),
    Kind.BUS: Shape(
        size=(12.00, 2.50, 3.40),
        smallest=(9.00, 2.30, 2.80),
        largest=(19.00, 2.60, 4.20),
        make=_bus,
        plain=plain_bus,
        relief=_TRUCK_RELIEF,
    ),
    Kind.MOTORCYCLE: Shape(
        size=(2.20, 0.80, 1.50),
        smallest=(2.00, 0.70, 1.45),
        largest=(2.30, 0.95, 1.75),
        make=lambda size, draw, _glass: rider_shapes.motorcycle(size, rider_proportions.motorcycle(draw)),
    ),
    Kind.BICYCLE: Shape(
        size=(1.60, 0.65, 1.70),
        smallest=(1.55, 0.50, 1.60),
        largest=(1.90, 0.70, 1.90),
        make=lambda size, draw, _glass: rider_shapes.bicycle(size, rider_proportions.bicycle(draw)),
    ),
    Kind.PEDESTRIAN: Shape(
        size=(0.30, 0.48, 1.72),
        smallest=(0.20, 0.38, 1.40),
        largest=(0.60, 0.70, 2.00),
        make=lambda size, draw, _glass: rider_shapes.pedestrian(size, rider_proportions.pedestrian(draw)),
    ),
    Kind.OBSTACLE: Shape(
        size=(1.0, 1.0, 1.0),
        smallest=(0.1, 0.1, 0.1),
        largest=(50.0, 50.0, 50.0),
        make=lambda size, _draw, _glass: plain(size),
    ),
}
