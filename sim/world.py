"""World record: the ground truth that a traffic source delivers, one frame at a time.

World frame: x east, y north, z up, metres; yaw counter-clockwise from x, radians in (-pi, pi].
A pose is the centre of the body's bounding box on the ground plane.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
import numpy.typing as npt

from luxloop.arrays import Bools, Floats, Ints

JOINTS = 7
"""Most joints of a vehicle."""
RARE = "rare"
"""Mark of a field that most records leave empty; then it has no part in hashes of records."""


class Kind(IntEnum):
    """Class of an actor. It decides the body shape and whether the actor is graded."""

    CAR = 0
    SUV = 1
    VAN = 2
    TRUCK = 3
    TRAILER_TRUCK = 4
    BUS = 5
    MOTORCYCLE = 6
    BICYCLE = 7
    PEDESTRIAN = 8
    OBSTACLE = 9


class Mode(IntEnum):
    """True motion mode of an actor; `luxloop.sim.modes` defines the limits."""

    STATIONARY = 0
    CONSTANT_VELOCITY = 1
    ACCELERATING = 2
    """Along or across the direction of travel: a turn is an acceleration, too."""


VEHICLE_KINDS = frozenset({Kind.CAR, Kind.SUV, Kind.VAN, Kind.TRUCK, Kind.TRAILER_TRUCK, Kind.BUS, Kind.MOTORCYCLE})


@dataclass(frozen=True, slots=True, eq=False)
class Ego:
    """The vehicle that carries the rig. The ego frame is this pose: box centre, on the ground."""

    pose_world: Floats
    """(3,) x [m], y [m], yaw [rad]."""
    velocity_world: Floats
    """(2,) [m/s]."""
    acceleration_world: Floats
    """(2,) [m/s^2]."""
    yaw_rate: float
    """[rad/s], counter-clockwise positive."""
    size: Floats
    """(3,) length, width, height [m]."""
    changes_lane: bool
    """As in `Actors`."""
    deviation: Floats
    """(2,) As in `Actors`."""
    ground_z: float
    """As in `Actors`."""
    attitude: Floats
    """(2,) As in `Actors`."""


def no_angles() -> Floats:
    """Return no angles at further joints, the default of records: their bodies have one joint or none."""
    return np.empty((0, JOINTS - 1))


@dataclass(frozen=True, slots=True, eq=False)
class Actors:
    """All other road users near the ego, one row each, sorted by id."""

    id: Ints
    """(N,) stable for the lifetime of the actor, never reused within a run."""
    name: npt.NDArray[np.str_]
    """(N,) the traffic simulator's name, to look the actor up there."""
    kind: npt.NDArray[np.uint8]
    """(N,) `Kind`."""
    pose_world: Floats
    """(N, 3) x [m], y [m], yaw [rad]."""
    velocity_world: Floats
    """(N, 2) [m/s], of the box centre."""
    acceleration_world: Floats
    """(N, 2) [m/s^2], of the box centre."""
    yaw_rate: Floats
    """(N,) [rad/s], counter-clockwise positive."""
    articulation: Floats
    """(N,) [rad] angle at the first joint: yaw of the tractor relative to the trailer, which defines the pose; 0 for
    rigid bodies. A bus has a front and a rear part in their place, a tram its first two sections."""
    mode: npt.NDArray[np.uint8]
    """(N,) `Mode`."""
    changes_lane: Bools
    """(N,) mask of actors in a lane change that the simulator makes in one step and the truth layer spreads."""
    deviation: Floats
    """(N, 2) [m] offset of the front bumper (highway-env: the centre) from its position in the simulator: ahead and to
    the left, along and across the direction of travel."""
    size: Floats
    """(N, 3) length, width, height [m]."""
    ground_z: Floats
    """(N,) height of the plane on which the wheels stand, under the pose [m]: that of the road."""
    attitude: Floats
    """(N, 2) pitch, positive with the front down, then roll, positive with the right side down, of the body against the
    horizontal [rad]."""
    reflectivity: Floats
    """(N,) paint's diffuse reflectivity at 905 nm, 0 to 1."""
    further_articulation: Floats = field(default_factory=no_angles)
    """(N, JOINTS - 1) [rad] the angles at the joints behind the first, of trams and trains, whose middle section
    defines the pose, see `luxloop.sim.sections`; 0 for others, and by default."""

    def __post_init__(self) -> None:
        if not len(self.further_articulation):
            object.__setattr__(self, "further_articulation", np.zeros((len(self.id), JOINTS - 1)))

    def __len__(self) -> int:
        return len(self.id)

    @property
    def is_bent(self) -> bool:
        """True if the angle at any joint of any actor is not 0."""
        return bool(self.articulation.any() or self.further_articulation.any())

    @property
    def joint_angles(self) -> Floats:
        """(N, JOINTS) [rad] yaw of each section relative to the next one, from the front; 0 beyond the last joint."""
        return np.column_stack([self.articulation, self.further_articulation])


@dataclass(frozen=True, slots=True)
class Collision:
    """A collision of the ego that the simulator reports and that no frame shows: it moves or halts those involved."""

    id: int
    """Id of the other road user, -1 if it was in no frame."""
    name: str
    """Its name in the simulator."""
    speed_mps: float
    """Speed of the one that drove into the other [m/s]."""


@dataclass(frozen=True, slots=True, eq=False)
class WorldFrame:
    """Ground truth of one instant."""

    index: int
    """Frames since the start of the run, 0 for the first."""
    time: float
    """[s] since the start of the run."""
    ego: Ego
    actors: Actors
    collisions: tuple[Collision, ...] = field(default=(), metadata={RARE: True})
    """Collisions since the last frame, of simulators that report them."""


@dataclass(frozen=True, slots=True, eq=False)
class Terrain:
    """Height of the ground on a regular grid: two triangles per cell.

    The diagonal from a cell's node (i, j) to (i + 1, j + 1) divides it. Beyond the grid the heights of its border
    continue outwards.
    """

    corner_world: Floats
    """(2,) x, y of node (0, 0) [m]."""
    cell: float
    """Distance of neighbouring nodes [m]."""
    height: Floats
    """(X, Y) height of each node [m], by x and y; at least two by two."""

    def height_at(self, places_world: Floats) -> Floats:
        """Return the heights [m] at places (..., 2) [m]."""
        place = (places_world - self.corner_world) / self.cell
        last = np.array(self.height.shape) - 1
        place = np.clip(place, 0.0, last)
        i, j = np.moveaxis(np.minimum(place.astype(np.int64), last - 1), -1, 0)
        u, v = place[..., 0] - i, place[..., 1] - j
        low, high = self.height[i, j], self.height[i + 1, j + 1]
        right, left = self.height[i + 1, j], self.height[i, j + 1]
        # the diagonal u = v divides the cell
        below: Floats = low + u * (right - low) + v * (high - right)
        above: Floats = low + v * (left - low) + u * (high - left)
        return np.where(u >= v, below, above)


@dataclass(frozen=True, slots=True, eq=False)
class Obstacles:
    """Static surroundings, delivered once per source: the ground, and upright faces on the sides of polygons.

    The faces have no lids.
    """

    vertices_world: Floats
    """(V, 2) corners of all polygons [m], each polygon closed implicitly."""
    offset: Ints
    """(M + 1,) polygon m holds vertices offset[m] to offset[m + 1]."""
    base: Floats
    """(M,) height of the lower edge above the ground [m]; 0 if it stands on the ground."""
    height: Floats
    """(M,) height of the upper edge above the ground [m]."""
    reflectivity: Floats
    """(M,) diffuse, 0 to 1."""
    terrain: Terrain | None = None
    """Height of the ground; None if it is the plane z = 0."""

    def __len__(self) -> int:
        return len(self.height)

    @classmethod
    def from_polygons(
        cls,
        polygons: Sequence[Floats],
        height: Sequence[float],
        reflectivity: float | Sequence[float] = 0.3,
        base: float | Sequence[float] = 0.0,
    ) -> "Obstacles":
        """Gather polygons, each (K, 2) in the world frame [m], K >= 2 (two points make a wall).

        `reflectivity` and `base` are scalars for all polygons or one value per polygon. The default reflectivity is an
        estimate for plaster and concrete at 905 nm.
        """
        counts = [len(polygon) for polygon in polygons]
        return cls(
            vertices_world=np.concatenate(polygons) if len(polygons) else np.empty((0, 2)),
            offset=np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
            base=np.full(len(polygons), base, dtype=np.float64),
            height=np.asarray(height, dtype=np.float64),
            reflectivity=np.full(len(polygons), reflectivity, dtype=np.float64),
        )
