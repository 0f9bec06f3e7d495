"""Configuration of scripted scenarios: ego, actors, rings of cars and obstacles."""

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats
from luxloop.sim.obstacles import Prism, StreetKind, build
from luxloop.sim.scripted.motions import Motion, Spin, Static, require_sequence
from luxloop.sim.world import Kind

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
"""[m] Default length, width, height."""

_GOLDEN_ANGLE_DEG = 180.0 * (3.0 - math.sqrt(5.0))


@dataclass(frozen=True, slots=True)
class ScriptedEgo:
    """The vehicle that carries the rig. Its start has no jitter."""

    x_m: float = 0.0
    """[m] East, of the box centre, at the start."""
    y_m: float = 0.0
    """[m] North."""
    yaw_deg: float = 0.0
    """[deg] Counter-clockwise from east."""
    size_m: Size = EGO_SIZE
    """[m] Length, width, height."""
    motion: list[Motion] = field(default_factory=lambda: [Static("static")])
    """Motions, one after the other."""

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
    """Class of the road user."""
    size_m: Size | None = None
    """[m] Length, width, height; defaults to the size of the kind."""
    reflectivity: float | None = None
    """Diffuse reflectivity of the paint, 0 to 1; drawn at random by default."""
    name: str = ""
    """Name in reports; `<kind>.<number>` by default."""
    motion: list[Motion] = field(default_factory=lambda: [Static("static")])
    """Motions, one after the other."""

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
    """Cars around the ego's start, one per range, at evenly spaced bearings, each turning on the spot.

    In one turn every car shows all its aspects, and no car occludes another. The initial aspects are spread by the
    golden angle, so that each frame contains a mix.
    """

    ranges_m: list[float]
    """[m] Distance from the ego's centre to each car's centre, counter-clockwise from the ego's heading."""
    rate_deg_per_s: float
    """[deg/s] Yaw rate of the cars."""
    kind: KindName = "car"
    """Class of the cars."""
    reflectivity: float | None = None
    """Diffuse reflectivity of the paint, 0 to 1; drawn at random by default."""

    def __post_init__(self) -> None:
        if not self.ranges_m or min(self.ranges_m) <= 0:
            raise ValueError("ranges_m needs at least one range, all of them positive")
        _require_reflectivity(self.reflectivity)

    def actors(self, ego: ScriptedEgo) -> list[ScriptedActor]:
        """Return the cars around the ego's start."""
        cars = []
        for n, range_m in enumerate(self.ranges_m):
            bearing = math.radians(ego.yaw_deg) + 2 * math.pi * n / len(self.ranges_m)
            car = ScriptedActor(
                x_m=ego.x_m + range_m * elementary.cos(bearing),
                y_m=ego.y_m + range_m * elementary.sin(bearing),
                yaw_deg=math.degrees(bearing) + n * _GOLDEN_ANGLE_DEG,
                kind=self.kind,
                reflectivity=self.reflectivity,
                name=f"ring.{n + 1}",
                motion=[Spin("spin", self.rate_deg_per_s)],
            )
            cars.append(car)
        return cars


@dataclass(frozen=True, slots=True)
class ScriptedObstacle:
    """A static occluder. Write a parked car as an actor without motion instead, so that it is graded."""

    corners_m: list[tuple[float, float]]
    """[m] x, y of the corners of a building (two make a free-standing wall); of points along a wall, barrier, fence or
    guard rail; or of the positions of all poles, trees, traffic-signs or bollards of this entry."""
    height_m: float | None = None
    """[m] Upper edge above the ground; defaults to that of the kind."""
    kind: StreetKind = "building"
    """Kind of obstacle."""
    base_m: float = 0.0
    """[m] Lower edge above the ground. For a guard rail it follows from the height."""
    diameter_m: float | None = None
    """[m] Diameter of a pole, tree, traffic-sign (its post) or bollard; defaults to that of the kind."""
    reflectivity: float | None = None
    """Diffuse reflectivity at 905 nm, 0 to 1; defaults to that of the kind."""

    def __post_init__(self) -> None:
        self.prisms()

    def prisms(self) -> list[Prism]:
        """Return the prisms of the obstacle."""
        points = np.array(self.corners_m, dtype=np.float64).reshape(-1, 2)
        return build(self.kind, points, self.height_m, self.base_m, self.diameter_m, self.reflectivity)


def _require_size(size: Size) -> None:
    if min(size) <= 0:
        raise ValueError("size_m needs a positive length, width and height")


def _require_reflectivity(reflectivity: float | None) -> None:
    if reflectivity is not None and not 0 <= reflectivity <= 1:
        raise ValueError("reflectivity must be between 0 and 1")
