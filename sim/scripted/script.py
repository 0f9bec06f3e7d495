"""The vocabulary of scripted scenarios: who stands where and does what."""

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from sim.arrays import Floats
from sim.obstacles import Prism, StreetKind, build
from sim.scripted.motions import Motion, Spin, Static, require_sequence
from sim.world import Kind

KindName = Literal[
    "car", "suv", "van", "truck", "trailer-truck", "bus", "motorcycle", "bicycle", "pedestrian", "obstacle"
]
Size = tuple[float, float, float]

EGO_SIZE: Size = (4.83, 1.91, 1.67)
"""[m] A second-generation Cadillac SRX."""

SIZE_BY_KIND: dict[Kind, Size] = {
    Kind.CAR: (4.70, 1.82, 1.46),
    Kind.SUV: (4.60, 1.88, 1.70),
    Kind.VAN: (5.50, 2.00, 2.30),
    Kind.TRUCK: (8.00, 2.50, 3.20),
    Kind.TRAILER_TRUCK: (16.50, 2.55, 4.00),
    Kind.BUS: (12.00, 2.50, 3.40),
    Kind.MOTORCYCLE: (2.20, 0.80, 1.50),
    Kind.BICYCLE: (1.60, 0.65, 1.70),
    Kind.PEDESTRIAN: (0.30, 0.48, 1.72),
    Kind.OBSTACLE: (1.00, 1.00, 1.00),
}
"""[m] Length, width, height of those that do not tell theirs."""

_GOLDEN_ANGLE_DEG = 180.0 * (3.0 - math.sqrt(5.0))


@dataclass(frozen=True, slots=True)
class ScriptedEgo:
    """The vehicle that carries the rig. It starts exactly where it is put."""

    x_m: float = 0.0
    """[m] East, of the box centre, at the start."""
    y_m: float = 0.0
    """[m] North."""
    yaw_deg: float = 0.0
    """[deg] Counter-clockwise from east."""
    size_m: Size = EGO_SIZE
    """[m] Length, width, height."""
    motion: list[Motion] = field(default_factory=lambda: [Static("static")])
    """What it does, one motion after the other."""

    def __post_init__(self) -> None:
        _require_size(self.size_m)
        require_sequence(self.motion)

    @property
    def start_world(self) -> Floats:
        """(3,) x [m], y [m], yaw [rad]."""
        return np.array([self.x_m, self.y_m, math.radians(self.yaw_deg)])


@dataclass(frozen=True, slots=True)
class ScriptedActor:
    """Any other road user."""

    x_m: float
    """[m] East, of the box centre, at the start."""
    y_m: float
    """[m] North."""
    yaw_deg: float = 0.0
    """[deg] Counter-clockwise from east."""
    kind: KindName = "car"
    """What it is."""
    size_m: Size | None = None
    """[m] Length, width, height; by kind where left out."""
    reflectivity: float | None = None
    """Of its paint, 0 to 1; drawn where left out."""
    name: str = ""
    """For people; `<kind>.<number>` where left out."""
    motion: list[Motion] = field(default_factory=lambda: [Static("static")])
    """What it does, one motion after the other."""

    def __post_init__(self) -> None:
        if self.size_m is not None:
            _require_size(self.size_m)
        _require_reflectivity(self.reflectivity)
        require_sequence(self.motion)

    @property
    def start_world(self) -> Floats:
        """(3,) x [m], y [m], yaw [rad], without jitter."""
        return np.array([self.x_m, self.y_m, math.radians(self.yaw_deg)])


@dataclass(frozen=True, slots=True)
class ScriptedRing:
    """Cars around the ego's start, one a range, at bearings evenly spread, each turning on the spot.

    In one turn every range shows every aspect, while no car hides another. The first aspects are spread by the golden
    angle, so that each frame holds a mix.
    """

    ranges_m: list[float]
    """[m] From the ego's centre to the cars' centres, counter-clockwise from the ego's heading."""
    rate_deg_per_s: float
    """[deg/s] How fast the aspect changes."""
    kind: KindName = "car"
    """What they are."""
    reflectivity: float | None = None
    """Of their paint, 0 to 1; drawn where left out."""

    def __post_init__(self) -> None:
        if not self.ranges_m or min(self.ranges_m) <= 0:
            raise ValueError("ranges_m takes at least one range, all of them positive")
        _require_reflectivity(self.reflectivity)

    def actors(self, ego: ScriptedEgo) -> list[ScriptedActor]:
        """Return the cars that stand around the ego's start."""
        cars = []
        for n, range_m in enumerate(self.ranges_m):
            bearing = math.radians(ego.yaw_deg) + 2 * math.pi * n / len(self.ranges_m)
            car = ScriptedActor(
                x_m=ego.x_m + range_m * math.cos(bearing),
                y_m=ego.y_m + range_m * math.sin(bearing),
                yaw_deg=math.degrees(bearing) + n * _GOLDEN_ANGLE_DEG,
                kind=self.kind,
                reflectivity=self.reflectivity,
                motion=[Spin("spin", self.rate_deg_per_s)],
            )
            cars.append(car)
        return cars


@dataclass(frozen=True, slots=True)
class ScriptedObstacle:
    """A static thing that blocks beams. A parked car is none: it is an actor without motion, so that it is graded."""

    corners_m: list[tuple[float, float]]
    """[m] x, y of the corners of a building (two make a free-standing wall); of points along a wall, barrier, fence or
    guard rail; or of every place where a pole, tree, traffic-sign or bollard of this sort stands."""
    height_m: float | None = None
    """[m] Of the upper edge above the ground; by kind where left out."""
    kind: StreetKind = "building"
    """What it is."""
    base_m: float = 0.0
    """[m] Of the lower edge above the ground. A guard rail's follows from its height."""
    diameter_m: float | None = None
    """[m] Of a pole, tree, traffic-sign (its post) or bollard; by kind where left out."""
    reflectivity: float | None = None
    """Diffuse, at 905 nm, 0 to 1; by kind where left out."""

    def __post_init__(self) -> None:
        self.prisms()

    def prisms(self) -> list[Prism]:
        """Return what it is made of."""
        points = np.array(self.corners_m, dtype=np.float64).reshape(-1, 2)
        return build(self.kind, points, self.height_m, self.base_m, self.diameter_m, self.reflectivity)


def _require_size(size: Size) -> None:
    if min(size) <= 0:
        raise ValueError("size_m takes a positive length, width and height")


def _require_reflectivity(reflectivity: float | None) -> None:
    if reflectivity is not None and not 0 <= reflectivity <= 1:
        raise ValueError("reflectivity lies between 0 and 1")
