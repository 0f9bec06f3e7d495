"""Proportions of trucks and buses."""

from dataclasses import dataclass

from luxloop.sensor_model.bodies.proportions import Draw
from luxloop.sensor_model.bodies.proportions.fitting_proportions import MirrorBox


@dataclass(frozen=True, slots=True)
class TruckProportions:
    """Trucks, with or without a trailer. Lengths [m], heights [m] above the ground."""

    clearance: float
    wheel_radius: float
    front_overhang: float
    rear_overhang: float
    """Rear axle, or the last of several, to the rear."""
    floor: float
    """Lower edge of the load body, which is open beneath."""
    cab: float
    """Length of the cab."""
    cab_share: float
    """Height of the cab's roof as a share of the vehicle's height."""
    windscreen_deg: float
    """From the horizontal."""
    radius: float
    """Radius of the front corners in plan."""
    front_bow: float
    """Sagitta of the cab's front over 0.75 m to either side of the middle."""
    mirror: MirrorBox


def truck(draw: Draw) -> TruckProportions:
    """Draw a box truck."""
    return TruckProportions(
        clearance=draw(0.30, 0.40),
        wheel_radius=draw(0.46, 0.52),
        front_overhang=draw(1.15, 1.35),
        rear_overhang=draw(1.5, 1.9),
        floor=draw(0.90, 1.05),
        cab=draw(1.75, 2.0),
        cab_share=draw(0.80, 0.88),
        windscreen_deg=draw(78.0, 86.0),
        radius=draw(0.10, 0.15),
        front_bow=draw(0.04, 0.10),
        mirror=MirrorBox(draw(0.16, 0.22), draw(0.17, 0.22), draw(0.5, 0.7), draw(1.75, 1.85), draw(0.46, 0.47)),
    )


def trailer_truck(draw: Draw) -> TruckProportions:
    """Draw a tractor with a semitrailer."""
    return TruckProportions(
        clearance=draw(0.30, 0.40),
        wheel_radius=draw(0.48, 0.52),
        front_overhang=draw(1.3, 1.45),
        rear_overhang=draw(2.85, 3.15),
        floor=draw(1.0, 1.2),
        cab=draw(2.1, 2.4),
        cab_share=draw(0.88, 0.96),
        windscreen_deg=draw(79.0, 87.0),
        radius=draw(0.12, 0.15),
        front_bow=draw(0.04, 0.10),
        mirror=MirrorBox(draw(0.16, 0.22), draw(0.17, 0.22), draw(0.5, 0.7), draw(1.75, 1.95), draw(0.475, 0.48)),
    )


@dataclass(frozen=True, slots=True)
class BusProportions:
    """Buses. Lengths [m], heights [m] above the ground."""

    clearance: float
    wheel_radius: float
    front_overhang: float
    rear_overhang: float
    belt: float
    windscreen_deg: float
    """From the horizontal."""
    radius: float
    """Radius of the corners in plan."""
    front_bow: float
    """Sagitta of the front over 0.75 m to either side of the middle."""
    rear_bow: float
    mirror: MirrorBox


def bus(draw: Draw) -> BusProportions:
    """Draw a bus."""
    return BusProportions(
        clearance=draw(0.28, 0.36),
        wheel_radius=draw(0.47, 0.52),
        front_overhang=draw(2.5, 2.8),
        rear_overhang=draw(3.0, 3.4),
        belt=draw(1.2, 1.4),
        windscreen_deg=draw(80.0, 88.0),
        radius=draw(0.10, 0.15),
        front_bow=draw(0.05, 0.12),
        rear_bow=draw(0.02, 0.05),
        mirror=MirrorBox(draw(0.16, 0.22), draw(0.17, 0.22), draw(0.5, 0.65), draw(1.85, 2.1), draw(0.475, 0.48)),
    )
