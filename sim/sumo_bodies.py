"""What SUMO's shapes are to us: kinds of road users, and obstacles."""

import math
from typing import Any

import numpy as np

from sim.source import TrafficInputError
from sim.world import Kind, Obstacles

KIND_BY_SHAPE = {
    "passenger": Kind.CAR,
    "passenger/van": Kind.VAN,
    "delivery": Kind.VAN,
    "emergency": Kind.VAN,
    "firebrigade": Kind.TRUCK,
    "army": Kind.TRUCK,
    "truck": Kind.TRUCK,
    "truck/semitrailer": Kind.TRAILER_TRUCK,
    "truck/1trailer": Kind.TRAILER_TRUCK,
    "bus": Kind.BUS,
    "rail": Kind.BUS,
    "motorcycle": Kind.MOTORCYCLE,
    "moped": Kind.MOTORCYCLE,
    "scooter": Kind.BICYCLE,
    "bicycle": Kind.BICYCLE,
    "pedestrian": Kind.PEDESTRIAN,
    "container": Kind.OBSTACLE,
    "ship": Kind.OBSTACLE,
    "aircraft": Kind.OBSTACLE,
}
"""By SUMO's guiShape, or its part before the slash; whatever is not listed (taxi, police, unknown) is a car."""

SUV_HEIGHT = 1.55
"""[m] SUMO has no SUV shape: a passenger car at least this high is one."""


def kind_of_shape(shape: str, height: float) -> Kind:
    """Return the kind of a vehicle with SUMO's guiShape `shape` and a height [m]."""
    kind = KIND_BY_SHAPE.get(shape, KIND_BY_SHAPE.get(shape.partition("/")[0], Kind.CAR))
    return Kind.SUV if kind is Kind.CAR and height >= SUV_HEIGHT else kind


def polygons_as_obstacles(polygon: Any, default_height: float) -> Obstacles:
    """Return the obstacles among the loaded polygons.

    Parameters
    ----------
    polygon
        libsumo's polygon domain.
    default_height
        Of buildings that do not tell theirs [m].

    Raises
    ------
    TrafficInputError
        A height is no positive number.
    """
    shapes, heights = [], []
    for name in sorted(polygon.getIDList()):
        height = polygon.getParameter(name, "height")
        if height or polygon.getType(name).startswith("building"):
            shape = np.array(polygon.getShape(name))[:, :2]
            closed = len(shape) > 2 and np.array_equal(shape[0], shape[-1])
            shapes.append(shape[:-1] if closed else shape)
            heights.append(_metres(name, height) if height else default_height)
    return Obstacles.from_polygons(shapes, heights)


def _metres(polygon: str, height: str) -> float:
    try:
        value = float(height)
    except ValueError:
        value = math.nan
    if not value > 0:
        raise TrafficInputError(f'polygon "{polygon}": height = "{height}"; write a positive number of metres')
    return value
