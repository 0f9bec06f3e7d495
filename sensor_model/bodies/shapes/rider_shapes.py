"""Motorcycles and bicycles with their riders, and pedestrians."""

from luxloop.sensor_model.bodies.proportions.rider_proportions import FigureProportions, RiderProportions
from luxloop.sensor_model.bodies.solids import HALF_FLAT, Solid, Vector, box, mirrored, prism
from luxloop.sensor_model.truth import Part

_HEAD = 0.13
"""[m] Half the width of a head with helmet."""


def motorcycle(size: Vector, p: RiderProportions) -> list[Solid]:
    """Make a motorcycle: wheels, tank and engine, handlebar, mirrors, and the rider."""
    length, width, _ = size
    front, rear = length / 2, -length / 2
    body = prism(
        Part.BODY,
        [
            (rear + 0.55, 0.25),
            (front - 0.75, 0.22),
            (front - 0.50, 0.60),
            (front - 0.65, p.bar - 0.04),
            (rear + 0.25, p.seat + 0.02),
            (rear + 0.12, p.seat - 0.05),
        ],
        0.18,
    )
    x_bar = front - 0.70
    stalk = box(
        Part.MIRROR, (x_bar + 0.02, x_bar + 0.07), (width / 2 - 0.10, width / 2 + 0.05), (p.bar + 0.10, p.bar + 0.20)
    )
    return [
        _wheel(front - p.wheel_radius, p),
        _wheel(rear + p.wheel_radius, p),
        body,
        _handlebar(x_bar, p.bar, width),
        *_rider(size, p, x_hips=rear + 0.80, z_feet=0.30, x_bar=x_bar),
        stalk,
        mirrored(stalk),
    ]


def bicycle(size: Vector, p: RiderProportions) -> list[Solid]:
    """Make a bicycle: wheels, frame, handlebar, and the rider."""
    length, width, _ = size
    front, rear = length / 2, -length / 2
    frame = prism(
        Part.BODY,
        [(rear + 0.33, 0.30), (-0.02, 0.24), (front - 0.40, 0.72), (front - 0.44, 0.80), (rear + 0.52, 0.78)],
        0.03,
    )
    return [
        _wheel(front - p.wheel_radius, p),
        _wheel(rear + p.wheel_radius, p),
        frame,
        _handlebar(front - 0.48, p.bar, width),
        *_rider(size, p, x_hips=rear + 0.50, z_feet=0.20, x_bar=front - 0.48),
    ]


def pedestrian(size: Vector, p: FigureProportions) -> list[Solid]:
    """Make a pedestrian: legs, torso with arms, head."""
    length, width, height = size
    depth, waist, neck = length / 2, p.waist * height, p.shoulders * height
    hips, head = p.hips * width / 2, p.head * width / 2
    legs = prism(
        Part.BODY,
        [(-0.5 * depth, 0.0), (0.9 * depth, 0.0), (0.8 * depth, waist), (-0.8 * depth, waist)],
        hips,
        [(waist, -3.0)],
    )
    torso = prism(
        Part.BODY,
        [
            (-0.75 * depth, waist - 0.05),
            (0.75 * depth, waist - 0.05),
            (depth, 0.9 * neck),
            (0.5 * depth, neck + 0.03),
            (-0.5 * depth, neck + 0.03),
            (-depth, 0.9 * neck),
        ],
        width / 2,
        [(0.9 * neck, -4.0), (0.9 * neck, 35.0)],
    )
    skull = prism(Part.BODY, _octagon(0.0, (neck + height) / 2, 0.8 * depth, (height - neck) / 2), head, [(neck, 3.0)])
    return [legs, torso, skull]


def _rider(size: Vector, p: RiderProportions, x_hips: float, z_feet: float, x_bar: float) -> list[Solid]:
    """Make a rider: legs astride, torso bent to the handlebar, arms, head; the head's top is the vehicle's height."""
    height = size[2]
    neck = height - 0.27
    x_neck = x_hips + p.bend
    legs = prism(
        Part.BODY,
        [
            (x_hips + 0.10, z_feet),
            (x_hips + 0.38, z_feet),
            (x_hips + 0.45, p.seat - 0.05),
            (x_hips + 0.35, p.seat + 0.10),
            (x_hips - 0.15, p.seat + 0.10),
            (x_hips - 0.15, p.seat - 0.10),
        ],
        p.hips,
    )
    torso = prism(
        Part.BODY,
        [
            (x_hips - 0.15, p.seat),
            (x_hips + 0.12, p.seat),
            (x_neck + 0.14, neck - 0.12),
            (x_neck + 0.06, neck + 0.04),
            (x_neck - 0.12, neck),
        ],
        p.shoulders,
        [(neck - 0.15, -6.0), (neck - 0.15, 25.0)],
    )
    head = prism(
        Part.BODY,
        _octagon(x_neck + 0.06, height - 0.14, 0.14, 0.14),
        _HEAD,
        [(height - 0.14, 20.0), (height - 0.14, -20.0)],
    )
    arms = prism(
        Part.BODY,
        [
            (x_neck + 0.02, neck - 0.20),
            (x_bar, p.bar - 0.03),
            (x_bar, p.bar + 0.04),
            (x_neck + 0.08, neck - 0.08),
        ],
        p.shoulders - 0.01,
    )
    return [legs, torso, arms, head]


def _wheel(x: float, p: RiderProportions) -> Solid:
    return prism(Part.WHEEL, _octagon(x, p.wheel_radius, p.wheel_radius, p.wheel_radius), p.wheel_width / 2)


def _octagon(x: float, z: float, half_length: float, half_height: float) -> list[tuple[float, float]]:
    """Return an octagonal profile inscribed in a box."""
    flat = HALF_FLAT
    ring = [(-flat, -1), (flat, -1), (1, -flat), (1, flat), (flat, 1), (-flat, 1), (-1, flat), (-1, -flat)]
    return [(x + half_length * dx, z + half_height * dz) for dx, dz in ring]


def _handlebar(x: float, z: float, width: float) -> Solid:
    return box(Part.BODY, (x - 0.02, x + 0.02), (-width / 2, width / 2), (z - 0.02, z + 0.02))
