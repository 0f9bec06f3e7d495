"""Kinds of road users by SUMO's vehicle shapes."""

from luxloop.sim.world import Kind

KIND_BY_SHAPE = {
    "passenger": Kind.CAR,
    "passenger/van": Kind.VAN,
    "delivery": Kind.VAN,
    "emergency": Kind.VAN,
    "firebrigade": Kind.TRUCK,
    "army": Kind.TRUCK,
    "truck": Kind.TRUCK,
    "truck/semitrailer": Kind.TRAILER_TRUCK,
    "truck/trailer": Kind.TRAILER_TRUCK,
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
"""By SUMO's guiShape, or its part before the slash; other shapes (taxi, police, unknown) are cars."""

SUV_HEIGHT = 1.55
"""[m] SUMO has no SUV shape: a passenger car at least this high is one."""


def kind_of_shape(shape: str, height: float) -> Kind:
    """Return the kind of a vehicle with SUMO's guiShape `shape` and a height [m]."""
    kind = KIND_BY_SHAPE.get(shape, KIND_BY_SHAPE.get(shape.partition("/")[0], Kind.CAR))
    return Kind.SUV if kind is Kind.CAR and height >= SUV_HEIGHT else kind
