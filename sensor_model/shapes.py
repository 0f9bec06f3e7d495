"""What each kind of road user looks like: a few convex pieces at a nominal size, in metres. Data; `bodies` scales it.

Body frame: x forward, y left, z up, origin at the box centre on the ground. All numbers are engineering estimates in
the ranges of published dimensions (hoods at 0.70 to 1.15 m, windscreens at 28 to 50 degrees, tumblehome of 3 to 22
degrees, bumper faces at 0.35 to 0.80 m); none is measured on a particular car.
"""

from dataclasses import dataclass

from sensor_model.truth import Part
from sim.world import Kind

Profile = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class Prism:
    """A side profile pulled across the width, symmetric about y = 0."""

    part: Part
    profile: Profile
    """Convex polygon of x, z [m], counter-clockwise with x to the right and z up."""
    half_width: float
    """[m], at the profile's lowest point."""
    inset: float = 0.0
    """How much narrower each side is at the profile's highest point (tumblehome) [m]."""
    chamfer: float = 0.0
    """Leg of the 45 degree cut at each corner of the plan [m]."""


@dataclass(frozen=True, slots=True)
class Pair:
    """A box on the left side and its mirror image on the right."""

    part: Part
    x: tuple[float, float]
    """Rear and front [m]."""
    y: tuple[float, float]
    """Inner and outer, of the left one [m]."""
    z: tuple[float, float]
    """Lower and upper [m]."""


@dataclass(frozen=True, slots=True)
class Shape:
    """Pieces of a nominal body of the given length, width and height [m]."""

    size: tuple[float, float, float]
    pieces: tuple[Prism | Pair, ...]


def box(part: Part, rear: float, front: float, half_width: float, bottom: float, top: float) -> Prism:
    """Make a prism with a rectangular profile [m]."""
    return Prism(part, ((rear, bottom), (front, bottom), (front, top), (rear, top)), half_width)


def _wheel(x: float, radius: float, outer: float, width: float) -> Pair:
    return Pair(Part.WHEEL, (x - radius, x + radius), (outer - width, outer), (0.0, 2.0 * radius))


def _side_mirror(x: float, z: float, side: float, size: tuple[float, float, float]) -> Pair:
    """Box of a size (length, width, height) at x and z; its inner 2 cm are in the body of half width `side` [m]."""
    length, width, height = size
    inner = side - 0.02
    return Pair(
        Part.MIRROR,
        (x - length / 2, x + length / 2),
        (inner, inner + width),
        (z - height / 2, z + height / 2),
    )


_SEDAN = Shape(
    size=(4.70, 1.82, 1.46),
    pieces=(
        Prism(
            Part.BODY,
            (
                (-2.10, 0.15),
                (2.05, 0.15),
                (2.35, 0.35),
                (2.35, 0.62),
                (2.25, 0.70),
                (0.95, 0.95),
                (-2.27, 1.00),
                (-2.35, 0.62),
                (-2.35, 0.35),
            ),
            half_width=0.91,
            chamfer=0.35,
        ),
        # Windscreen at 30 degrees, backlight at 30 degrees over a deck of 0.62 m, tumblehome 17 degrees.
        Prism(
            Part.GREENHOUSE,
            ((-1.74, 0.95), (0.95, 0.95), (0.07, 1.46), (-0.85, 1.46)),
            half_width=0.91,
            inset=0.16,
        ),
        _side_mirror(0.75, 1.00, 0.91, (0.15, 0.20, 0.15)),
        _wheel(1.42, 0.32, 0.91, 0.20),
        _wheel(-1.35, 0.32, 0.91, 0.20),
    ),
)

_SUV = Shape(
    size=(4.60, 1.88, 1.70),
    pieces=(
        Prism(
            Part.BODY,
            (
                (-2.08, 0.20),
                (2.05, 0.20),
                (2.30, 0.40),
                (2.30, 0.75),
                (2.20, 0.92),
                (1.05, 1.08),
                (-2.26, 1.10),
                (-2.30, 0.75),
                (-2.30, 0.40),
            ),
            half_width=0.94,
            chamfer=0.30,
        ),
        # Windscreen at 34 degrees, tailgate at 65 degrees, tumblehome 13 degrees.
        Prism(
            Part.GREENHOUSE,
            ((-2.20, 1.08), (1.05, 1.08), (0.13, 1.70), (-1.91, 1.70)),
            half_width=0.94,
            inset=0.14,
        ),
        _side_mirror(0.83, 1.15, 0.94, (0.15, 0.20, 0.15)),
        _wheel(1.40, 0.36, 0.94, 0.22),
        _wheel(-1.30, 0.36, 0.94, 0.22),
    ),
)

_VAN = Shape(
    size=(5.50, 2.00, 2.30),
    pieces=(
        Prism(
            Part.BODY,
            (
                (-2.55, 0.18),
                (2.50, 0.18),
                (2.75, 0.35),
                (2.75, 0.75),
                (2.65, 0.95),
                (1.95, 1.15),
                (-2.75, 1.16),
                (-2.75, 0.35),
            ),
            half_width=1.00,
            chamfer=0.20,
        ),
        # Sheet-metal load space behind a glazed cab with a windscreen at 45 degrees.
        Prism(
            Part.BODY,
            ((-2.75, 1.15), (0.55, 1.15), (0.55, 2.30), (-2.66, 2.30)),
            half_width=1.00,
            inset=0.10,
        ),
        Prism(
            Part.GREENHOUSE,
            ((0.55, 1.15), (1.95, 1.15), (0.80, 2.30), (0.55, 2.30)),
            half_width=1.00,
            inset=0.10,
        ),
        _side_mirror(1.65, 1.25, 1.00, (0.15, 0.22, 0.25)),
        _wheel(1.75, 0.34, 1.00, 0.22),
        _wheel(-1.55, 0.34, 1.00, 0.22),
    ),
)

_TRUCK = Shape(
    size=(8.00, 2.50, 3.20),
    pieces=(
        Prism(
            Part.BODY,
            ((2.10, 0.30), (3.95, 0.30), (4.00, 0.40), (4.00, 1.30), (3.85, 2.70), (2.10, 2.70)),
            half_width=1.25,
            chamfer=0.10,
        ),
        box(Part.BODY, -4.00, 2.00, 1.25, 0.30, 3.20),
        _side_mirror(3.80, 1.80, 1.25, (0.20, 0.25, 0.60)),
        _wheel(2.90, 0.50, 1.25, 0.30),
        _wheel(-2.30, 0.50, 1.25, 0.30),
    ),
)

_TRAILER_TRUCK = Shape(
    size=(16.50, 2.55, 4.00),
    pieces=(
        Prism(
            Part.BODY,
            ((5.90, 0.40), (8.20, 0.40), (8.25, 0.50), (8.25, 1.40), (8.05, 3.60), (5.90, 3.60)),
            half_width=1.275,
            chamfer=0.15,
        ),
        # The trailer is open below its floor, but for the frame, the wheels and the underrun bar at the rear.
        box(Part.BODY, -8.25, 5.50, 1.275, 1.00, 4.00),
        box(Part.BODY, -8.10, 7.50, 0.45, 0.70, 1.00),
        box(Part.BODY, -8.25, -8.10, 1.20, 0.40, 0.60),
        _side_mirror(8.00, 1.80, 1.275, (0.20, 0.25, 0.60)),
        _wheel(6.90, 0.50, 1.275, 0.30),
        _wheel(3.30, 0.50, 1.275, 0.60),
        _wheel(-4.30, 0.50, 1.275, 0.40),
        _wheel(-5.60, 0.50, 1.275, 0.40),
        _wheel(-6.90, 0.50, 1.275, 0.40),
    ),
)

_BUS = Shape(
    size=(12.00, 2.50, 3.40),
    pieces=(
        Prism(
            Part.BODY,
            ((-5.80, 0.30), (5.80, 0.30), (6.00, 0.40), (6.00, 1.30), (-6.00, 1.30), (-6.00, 0.40)),
            half_width=1.25,
            chamfer=0.15,
        ),
        Prism(
            Part.GREENHOUSE,
            ((-6.00, 1.30), (6.00, 1.30), (5.75, 3.00), (5.55, 3.40), (-6.00, 3.40)),
            half_width=1.25,
            inset=0.05,
            chamfer=0.15,
        ),
        _side_mirror(5.85, 1.80, 1.25, (0.20, 0.25, 0.60)),
        _wheel(3.30, 0.50, 1.25, 0.30),
        _wheel(-2.80, 0.50, 1.25, 0.30),
    ),
)

_MOTORCYCLE = Shape(
    size=(2.20, 0.80, 1.50),
    pieces=(
        box(Part.WHEEL, 0.48, 1.10, 0.08, 0.00, 0.62),
        box(Part.WHEEL, -1.10, -0.48, 0.08, 0.00, 0.62),
        Prism(
            Part.BODY,
            ((-0.60, 0.25), (0.50, 0.25), (0.70, 0.70), (0.45, 1.00), (-0.80, 0.90), (-0.95, 0.75)),
            half_width=0.20,
        ),
        # The handlebar, and the rider leaning to it.
        box(Part.BODY, 0.35, 0.45, 0.40, 0.95, 1.05),
        Prism(
            Part.BODY,
            ((-0.50, 0.70), (0.10, 0.70), (0.30, 1.35), (0.15, 1.50), (-0.10, 1.50), (-0.45, 1.10)),
            half_width=0.28,
            inset=0.12,
            chamfer=0.05,
        ),
        Pair(Part.MIRROR, (0.38, 0.43), (0.30, 0.45), (1.10, 1.20)),
    ),
)

_BICYCLE = Shape(
    size=(1.60, 0.65, 1.70),
    pieces=(
        box(Part.WHEEL, 0.12, 0.80, 0.03, 0.00, 0.68),
        box(Part.WHEEL, -0.80, -0.12, 0.03, 0.00, 0.68),
        box(Part.BODY, 0.35, 0.42, 0.325, 0.95, 1.05),
        Prism(
            Part.BODY,
            ((-0.30, 0.40), (0.20, 0.40), (0.35, 1.30), (0.25, 1.70), (0.00, 1.70), (-0.35, 1.00)),
            half_width=0.22,
            inset=0.08,
            chamfer=0.05,
        ),
    ),
)

_PEDESTRIAN = Shape(
    size=(0.30, 0.48, 1.72),
    pieces=(
        Prism(
            Part.BODY,
            ((-0.12, 0.00), (0.12, 0.00), (0.15, 1.20), (0.10, 1.72), (-0.10, 1.72), (-0.15, 1.20)),
            half_width=0.24,
            inset=0.10,
            chamfer=0.05,
        ),
    ),
)

PLAIN = Shape(size=(1.0, 1.0, 1.0), pieces=(box(Part.BODY, -0.5, 0.5, 0.5, 0.0, 1.0),))
"""The bounding prism from the ground to the top."""

SHAPES = {
    Kind.CAR: _SEDAN,
    Kind.SUV: _SUV,
    Kind.VAN: _VAN,
    Kind.TRUCK: _TRUCK,
    Kind.TRAILER_TRUCK: _TRAILER_TRUCK,
    Kind.BUS: _BUS,
    Kind.MOTORCYCLE: _MOTORCYCLE,
    Kind.BICYCLE: _BICYCLE,
    Kind.PEDESTRIAN: _PEDESTRIAN,
    Kind.OBSTACLE: PLAIN,
}
