"""Names of nuScenes for kinds, motion and visibility of actors."""

from luxloop.sim.world import Kind, Mode

CATEGORIES = {
    Kind.CAR: "vehicle.car", Kind.SUV: "vehicle.car", Kind.VAN: "vehicle.car", Kind.TRUCK: "vehicle.truck",
    Kind.TRAILER_TRUCK: "vehicle.truck", Kind.BUS: "vehicle.bus.rigid", Kind.MOTORCYCLE: "vehicle.motorcycle",
    Kind.BICYCLE: "vehicle.bicycle", Kind.PEDESTRIAN: "human.pedestrian.adult", Kind.OBSTACLE: "movable_object.debris",
}  # fmt: skip
CLASSES = {
    "vehicle.bicycle": "bicycle", "vehicle.bus.bendy": "bus", "vehicle.bus.rigid": "bus", "vehicle.car": "car",
    "vehicle.motorcycle": "motorcycle", "human.pedestrian.adult": "pedestrian", "human.pedestrian.child": "pedestrian",
    "human.pedestrian.construction_worker": "pedestrian", "human.pedestrian.police_officer": "pedestrian",
    "vehicle.trailer": "trailer", "vehicle.truck": "truck",
    **{name: name for name in ("bicycle", "bus", "car", "motorcycle", "pedestrian", "trailer", "truck")},
}  # fmt: skip
"""Classes of the tracking task by category, from the README of its evaluation, and by the categories of T4 data sets;
all other categories are ignored."""
RIDDEN = (Kind.MOTORCYCLE, Kind.BICYCLE)
ATTRIBUTES = (
    "vehicle.moving", "vehicle.stopped", "cycle.with_rider", "pedestrian.moving", "pedestrian.standing",
)  # fmt: skip
VISIBILITIES = {"1": (0.4, "v0-40"), "2": (0.6, "v40-60"), "3": (0.8, "v60-80"), "4": (1.0, "v80-100")}
"""Upper end and level of the visible fraction by token, as in nuScenes; 1 is in the last."""


def visibility(fraction: float) -> str:
    """Return the token of a visible fraction."""
    return next((token for token, (end, _) in VISIBILITIES.items() if fraction < end), "4")


def attributes(kind: Kind, mode: int) -> list[str]:
    """Return the attributes of an actor; obstacles have none."""
    stands = mode == Mode.STATIONARY
    if kind in RIDDEN:
        return ["cycle.with_rider"]
    if kind == Kind.PEDESTRIAN:
        return ["pedestrian.standing" if stands else "pedestrian.moving"]
    return [] if kind == Kind.OBSTACLE else ["vehicle.stopped" if stands else "vehicle.moving"]
