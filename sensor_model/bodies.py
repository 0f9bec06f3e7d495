"""Actors as convex bodies: which pieces an actor is made of, and where they stand in the ego frame."""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from sensor_model.shapes import PLAIN, SHAPES, Pair, Prism, Shape
from sensor_model.truth import Part
from sim.world import Actors, Kind

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

_CORNERS = np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]])


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """A convex piece in the frame of its body (x forward, y left, z up, box centre on the ground).

    It is the set of points with normal . point <= offset for all its planes.
    """

    part: Part
    planes: Floats
    """(K, 4) outward unit normal, and offset [m]."""
    bounds: Floats
    """(2, 3) lower and upper corner of the box around it [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Bodies:
    """A bodies in the ego frame, flat: P solids and Q planes in all."""

    pose_ego: Floats
    """(A, 3) x [m], y [m], yaw [rad]."""
    bounds: Floats
    """(A, 2, 3) box around all of a body's solids, mirrors included, in the body's frame [m]."""
    body_solid: Ints
    """(A + 1,) body a has solids body_solid[a] to body_solid[a + 1]."""
    solid_plane: Ints
    """(P + 1,) solid p has planes solid_plane[p] to solid_plane[p + 1]."""
    planes: Floats
    """(Q, 4) outward unit normal and offset, in the body's frame [m]."""
    plane_part: npt.NDArray[np.uint8]
    """(Q,) `Part` of the plane's solid."""

    def __len__(self) -> int:
        return len(self.pose_ego)


class BodyShop:
    """Builds the bodies of a frame's actors; unchanged actors are not built again."""

    def __init__(self, *, mirrors: bool, plain: bool) -> None:
        self._mirrors = mirrors
        self._plain = plain
        self._kind_and_size = np.empty((0, 4))
        self._packed = _pack([])

    def place(self, actors: Actors, ego_pose_world: Floats) -> Bodies:
        """Return the bodies of all actors, in their order, as seen from an ego pose (3,) x, y [m], yaw [rad]."""
        kind_and_size = np.column_stack([actors.kind, actors.size])
        if not np.array_equal(kind_and_size, self._kind_and_size):
            self._packed = _pack([self._solids(*row) for row in kind_and_size.tolist()])
            self._kind_and_size = kind_and_size
        return replace(self._packed, pose_ego=relative_pose(actors.pose_world, ego_pose_world))

    def _solids(self, kind: float, length: float, width: float, height: float) -> tuple[Solid, ...]:
        return body_solids(Kind(int(kind)), length, width, height, mirrors=self._mirrors, plain=self._plain)


@lru_cache(maxsize=4096)
def body_solids(
    kind: Kind, length: float, width: float, height: float, *, mirrors: bool, plain: bool
) -> tuple[Solid, ...]:
    """Scale the nominal shape of a kind to an actor's size [m].

    Parameters
    ----------
    mirrors
        Whether the body has its side mirrors, which alone stick out of length x width x height.
    plain
        Whether its shape is the bounding prism from the ground to its height (side mirrors stay).
    """
    size = np.array([length, width, height])
    solids = _scaled(SHAPES[kind], size)
    if plain:
        solids = _scaled(PLAIN, size) + [solid for solid in solids if solid.part == Part.MIRROR]
    return tuple(solid for solid in solids if mirrors or solid.part != Part.MIRROR)


def relative_pose(pose_world: Floats, ego_pose_world: Floats) -> Floats:
    """Poses (..., 3) of the world frame in the ego frame: x, y [m], yaw [rad], not wrapped."""
    x, y = np.moveaxis(pose_world[..., :2] - ego_pose_world[:2], -1, 0)
    cos, sin = np.cos(ego_pose_world[2]), np.sin(ego_pose_world[2])
    return np.stack([cos * x + sin * y, cos * y - sin * x, pose_world[..., 2] - ego_pose_world[2]], axis=-1)


def _scaled(shape: Shape, size: Floats) -> list[Solid]:
    """Solids of a shape stretched to a size (3,): planes n . p <= d become (n / s) . p <= d, normalised."""
    scale = size / shape.size
    solids = []
    for nominal in [solid for piece in shape.pieces for solid in _solids(piece)]:
        planes = np.column_stack([nominal.planes[:, :3] / scale, nominal.planes[:, 3]])
        planes /= np.linalg.norm(planes[:, :3], axis=1, keepdims=True)
        solids.append(Solid(nominal.part, planes, nominal.bounds * scale))
    return solids


def _solids(piece: Prism | Pair) -> tuple[Solid, ...]:
    return (_prism(piece),) if isinstance(piece, Prism) else (_box(piece, 1.0), _box(piece, -1.0))


def _prism(prism: Prism) -> Solid:
    """Half-spaces of the profile's edges, the two sides and the four cut corners."""
    profile = np.array(prism.profile)
    (rear, bottom), (front, top) = profile.min(axis=0), profile.max(axis=0)
    dx, dz = (np.roll(profile, -1, axis=0) - profile).T
    edges = np.column_stack([dz, np.zeros_like(dx), -dx, dz * profile[:, 0] - dx * profile[:, 1]])
    lean = prism.inset / (top - bottom)
    sides = np.array([(0.0, side, lean, prism.half_width + lean * bottom) for side in (1.0, -1.0)])
    planes = [edges, sides]
    if prism.chamfer:
        reach = np.where(_CORNERS[:, 0] > 0.0, front, -rear) + prism.half_width - prism.chamfer
        planes.append(np.column_stack([_CORNERS, np.zeros(4), reach]))
    bounds = np.array([(rear, -prism.half_width, bottom), (front, prism.half_width, top)])
    return Solid(prism.part, np.concatenate(planes), bounds)


def _box(pair: Pair, side: float) -> Solid:
    """One box of a pair: side +1 is the left one, -1 the right."""
    y = sorted(side * y for y in pair.y)
    bounds = np.array([pair.x, y, pair.z]).T
    axes = np.eye(3)
    planes = np.concatenate([np.column_stack([-axes, -bounds[0]]), np.column_stack([axes, bounds[1]])])
    return Solid(pair.part, planes, bounds)


def _pack(bodies: list[tuple[Solid, ...]]) -> Bodies:
    """Flatten bodies, each standing at the origin."""
    solids = [solid for body in bodies for solid in body]
    counts = [len(solid.planes) for solid in solids]
    bounds = [_around(body) for body in bodies]
    return Bodies(
        pose_ego=np.zeros((len(bodies), 3)),
        bounds=np.array(bounds).reshape(-1, 2, 3),
        body_solid=np.cumsum([0, *(len(body) for body in bodies)], dtype=np.int64),
        solid_plane=np.cumsum([0, *counts], dtype=np.int64),
        planes=np.concatenate([np.empty((0, 4)), *(solid.planes for solid in solids)]),
        plane_part=np.repeat(np.array([solid.part for solid in solids], dtype=np.uint8), counts),
    )


def _around(solids: tuple[Solid, ...]) -> Floats:
    """(2, 3) box around all solids [m]."""
    bounds = np.stack([solid.bounds for solid in solids])
    return np.stack([bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)])
