"""Bodies of all actors of a frame: convex solids and their poses in the ego frame."""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from luxloop import elementary, elementwise
from luxloop.arrays import Bools, Bytes, Floats, Ints
from luxloop.sensor_model.bodies.body import WAVES, Appearance, Body, build
from luxloop.sensor_model.bodies.kernels.tilting import tilt_solids
from luxloop.sensor_model.bodies.materials import Glass
from luxloop.sensor_model.bodies.proportions import Draw
from luxloop.sensor_model.bodies.rotation import rotate_boxes, rotate_planes, tilt_rotations
from luxloop.sim.sections import section_moves, sections
from luxloop.sim.world import Actors, Ego, Kind, WorldFrame


@dataclass(frozen=True, slots=True, eq=False)
class Bodies:
    """A bodies in the ego frame, in flat arrays: P solids and Q planes in all.

    The frame of an articulated body is that of its trailer, or middle section. The angles at its joints and the
    attitude are constant during a scan, which lasts milliseconds.

    The level frame of a body is its pose in the horizontal ego frame; z is the height above the road under the ego. The
    body tilts by its attitude about the point of the road under its pose. The roll axis of passenger cars is near the
    road (Gillespie 1992, "Fundamentals of Vehicle Dynamics", chapter 7), and riders lean about the line through their
    tyres. Solids that stand on the road, such as wheels, tilt too, by 2 cm on a braking car, and reach down to it.
    """

    pose_ego: Floats
    """(A, 3) x [m], y [m], yaw [rad]."""
    ground_z: Floats
    """(A,) height of the road under the body above that under the ego [m]."""
    R_level_body: Floats
    """(A, 3, 3) tilt by the attitude: level = R body + (0, 0, ground_z)."""
    velocity_ego: Floats
    """(A, 2) over ground, along the axes of the ego frame [m/s]."""
    acceleration_ego: Floats
    """(A, 2) over ground, along the axes of the ego frame [m/s^2]."""
    yaw_rate: Floats
    """(A,) over ground [rad/s]."""
    bounds: Floats
    """(A, 2, 3) box around all of a body's solids, mirrors included, in the level frame [m]."""
    body_solid: Ints
    """(A + 1,) body a has solids body_solid[a] to body_solid[a + 1]."""
    solid_plane: Ints
    """(P + 1,) solid p has planes solid_plane[p] to solid_plane[p + 1]."""
    solid_bounds: Floats
    """(P, 2, 3) box around the solid, in the level frame [m]."""
    solid_inner: Bools
    """(P,) True if the solid is behind glass: only beams that pass a pane of the same body hit it."""
    solid_ahead: Ints
    """(P,) number of the solid's section ahead of the one that defines the pose, see `Solid`."""
    planes: Floats
    """(Q, 4) outward unit normal and offset, in the level frame [m]."""
    planes_body: Floats
    """(Q, 4) the same in the body's frame."""
    plane_turn: Floats
    """(Q,) angle by which the plane is rotated with its section, counter-clockwise [rad]."""
    plane_pivot: Floats
    """(Q, 3) point of the section in the level frame [m]: x on the axis of the straight body, and x, y in the bent one;
    0 for planes that are not rotated."""
    plane_part: Bytes
    """(Q,) `Part`."""
    plane_reflectivity: Floats
    """(Q,) diffuse, 0 to 1; that of the actor's paint for painted planes."""
    plane_transmission: Floats
    """(Q,) two-way power transmission; 0 for opaque planes."""
    plane_relief: Floats
    """(Q,) standard deviation of the surface from the plane [m]."""
    relief_waves: Floats
    """(A, WAVES, 4) wave vectors [rad/m] and phases [rad] of the relief, in the body's frame."""
    body_outline: Ints
    """(A + 1,) the outline of body a has edges body_outline[a] to body_outline[a + 1]."""
    outline: Floats
    """(E, 3) convex outlines in plan, without articulation and side mirrors: outward unit normals and offsets of their
    edges, in the body's frame [m]."""

    def __len__(self) -> int:
        return len(self.pose_ego)

    @property
    def motion(self) -> Floats:
        """(A, 8) pose x, y, yaw; velocity x, y; acceleration x, y; yaw rate."""
        return np.column_stack([self.pose_ego, self.velocity_ego, self.acceleration_ego, self.yaw_rate])


class BodyFactory:
    """Factory of the bodies of a frame's actors; bodies of unchanged actors are cached.

    Parameters
    ----------
    mirrors
        If True, vehicles have side mirrors, the only parts outside of length x width x height.
    plain
        If True, a body is its bounding prism from the ground to its height; side mirrors stay.
    glass
        Glass of the windows.
    seed
        Seed of the proportions, which are drawn per actor; None selects the middle of all ranges.
    """

    def __init__(self, *, mirrors: bool, plain: bool, glass: Glass, seed: int | None) -> None:
        self._mirrors = mirrors
        self._plain = plain
        self._glass = glass
        self._seed = seed
        self._appearances = np.empty((0, 5))
        self._names = np.empty(0, np.str_)
        self._built: dict[Appearance, Body] = {}
        self._straight = _pack([])

    def place(self, frame: WorldFrame) -> Bodies:
        """Return the bodies of a frame's actors, in their order, as seen from the ego."""
        actors, ego = frame.actors, frame.ego
        appearances = np.column_stack([actors.kind, actors.size, actors.reflectivity])
        if not (np.array_equal(appearances, self._appearances) and np.array_equal(actors.name, self._names)):
            present = [
                Appearance(str(name), Kind(int(kind)), (length, width, height), paint)
                for name, (kind, length, width, height, paint) in zip(actors.name, appearances.tolist(), strict=True)
            ]
            self._built = {one: self._built.get(one) or self._build(one) for one in present}
            self._straight = _pack([self._built[one] for one in present])
            self._appearances, self._names = appearances, actors.name
        bodies = _articulated(self._straight, actors) if actors.is_bent else self._straight
        ground_z = actors.ground_z - ego.ground_z
        if actors.attitude.any() or ground_z.any():
            bodies = _tilted(bodies, actors.attitude, ground_z)
        return _placed(bodies, actors, ego)

    def _build(self, appearance: Appearance) -> Body:
        return _body(appearance, self._seed, self._glass, self._mirrors, self._plain)


@lru_cache(maxsize=256)
def _body(appearance: Appearance, seed: int | None, glass: Glass, mirrors: bool, plain: bool) -> Body:
    """Return a body, which is built once for all runs with the same seed in a process."""
    return build(appearance, Draw(seed, appearance.name), glass, mirrors=mirrors, as_prism=plain)


def _pack(bodies: list[Body]) -> Bodies:
    """Concatenate bodies, each at the origin."""
    count, no_counts = len(bodies), np.empty(0, np.int64)
    planes = np.concatenate([np.empty((0, 4)), *(body.planes for body in bodies)])
    return Bodies(
        pose_ego=np.zeros((count, 3)),
        ground_z=np.zeros(count),
        R_level_body=np.tile(np.eye(3), (count, 1, 1)),
        velocity_ego=np.zeros((count, 2)),
        acceleration_ego=np.zeros((count, 2)),
        yaw_rate=np.zeros(count),
        bounds=np.array([body.bounds for body in bodies]).reshape(count, 2, 3),
        body_solid=_offsets(np.array([len(body.solid_inner) for body in bodies], dtype=np.int64)),
        solid_plane=_offsets(np.concatenate([no_counts, *(body.planes_of_solid for body in bodies)])),
        solid_bounds=np.concatenate([np.empty((0, 2, 3)), *(body.solid_bounds for body in bodies)]),
        solid_inner=np.concatenate([np.empty(0, np.bool_), *(body.solid_inner for body in bodies)]),
        solid_ahead=np.concatenate([no_counts, *(body.solid_ahead for body in bodies)]),
        planes=planes,
        planes_body=planes,
        plane_turn=np.zeros(len(planes)),
        plane_pivot=np.zeros((len(planes), 3)),
        plane_part=np.concatenate([np.empty(0, np.uint8), *(body.plane_part for body in bodies)]),
        plane_reflectivity=np.concatenate([np.empty(0), *(body.plane_reflectivity for body in bodies)]),
        plane_transmission=np.concatenate([np.empty(0), *(body.plane_transmission for body in bodies)]),
        plane_relief=np.concatenate([np.empty(0), *(body.plane_relief for body in bodies)]),
        relief_waves=np.array([body.relief_waves for body in bodies]).reshape(count, WAVES, 4),
        body_outline=_offsets(np.array([len(body.outline) for body in bodies], dtype=np.int64)),
        outline=np.concatenate([np.empty((0, 3)), *(body.outline for body in bodies)]),
    )


def _offsets(counts: Ints) -> Ints:
    return np.concatenate([[0], np.cumsum(counts)])


def _articulated(straight: Bodies, actors: Actors) -> Bodies:
    """Rotate the sections of bent bodies against the one that defines the pose."""
    solids, planes = np.diff(straight.body_solid), np.diff(straight.solid_plane)
    angles = actors.joint_angles
    bent = np.flatnonzero(angles.any(axis=1))
    length = actors.size[bent, 0]
    found = sections(actors.kind[bent], length)
    moves = section_moves(found, length, angles[bent])
    of_body = np.repeat(np.arange(len(actors)), solids)
    solid = np.flatnonzero(np.isin(of_body, bent) & (straight.solid_ahead != 0))
    row = np.searchsorted(bent, of_body[solid])
    section = found.middle[row] - straight.solid_ahead[solid]
    solid_turn, solid_pivot = np.zeros(len(of_body)), np.zeros((len(of_body), 3))
    solid_turn[solid] = moves.turn[row, section]
    solid_pivot[solid] = np.column_stack([moves.pivot[row, section], moves.moved[row, section]])
    plane_turn, plane_pivot = np.repeat(solid_turn, planes), np.repeat(solid_pivot, planes, axis=0)
    plane = np.flatnonzero(np.repeat(np.isin(np.arange(len(of_body)), solid), planes))
    bent_bounds, bent_planes = straight.solid_bounds.copy(), straight.planes.copy()
    bent_bounds[solid] = rotate_boxes(bent_bounds[solid], solid_pivot[solid], solid_turn[solid])
    bent_planes[plane] = rotate_planes(bent_planes[plane], plane_pivot[plane], plane_turn[plane])
    low, high = bent_bounds[:, 0], bent_bounds[:, 1]
    first = straight.body_solid[:-1]
    return replace(
        straight,
        bounds=np.stack([np.minimum.reduceat(low, first), np.maximum.reduceat(high, first)], axis=1),
        solid_bounds=bent_bounds,
        planes=bent_planes,
        planes_body=bent_planes,
        plane_turn=plane_turn,
        plane_pivot=plane_pivot,
    )


def _tilted(level: Bodies, attitude: Floats, ground_z: Floats) -> Bodies:
    """Tilt bodies by their attitudes (A, 2) and raise them by heights (A,) [m]."""
    rotation = tilt_rotations(attitude)
    bounds, solid_bounds, planes, planes_body = tilt_solids(
        np.ascontiguousarray(attitude), rotation, ground_z, level.body_solid, level.solid_plane, level.solid_bounds,
        level.planes,
    )  # fmt: skip
    return replace(
        level,
        ground_z=ground_z,
        R_level_body=rotation,
        bounds=bounds,
        solid_bounds=solid_bounds,
        planes=planes,
        planes_body=planes_body,
    )


def _placed(bodies: Bodies, actors: Actors, ego: Ego) -> Bodies:
    cos, sin = elementary.cos(ego.pose_world[2]), elementary.sin(ego.pose_world[2])
    R_world_ego = np.array([[cos, -sin], [sin, cos]])
    return replace(
        bodies,
        pose_ego=relative_pose(actors.pose_world, ego.pose_world),
        velocity_ego=elementwise.product(actors.velocity_world, R_world_ego),
        acceleration_ego=elementwise.product(actors.acceleration_world, R_world_ego),
        yaw_rate=actors.yaw_rate,
    )


def relative_pose(pose_world: Floats, ego_pose_world: Floats) -> Floats:
    """Transform poses (..., 3) from the world frame to the ego frame: x, y [m], yaw [rad], not wrapped."""
    position = relative_positions(pose_world[..., :2], ego_pose_world)
    return np.concatenate([position, pose_world[..., 2:] - ego_pose_world[..., 2:]], axis=-1)


def relative_positions(positions: Floats, poses: Floats) -> Floats:
    """Transform positions (..., 2) to the frame of a pose (3,), or each to that of its pose (..., 3) [m]."""
    offset = positions - poses[..., :2]
    x, y = offset[..., 0], offset[..., 1]
    cos, sin = elementwise.cos(poses[..., 2]), elementwise.sin(poses[..., 2])
    return np.stack([cos * x + sin * y, cos * y - sin * x], axis=-1)
