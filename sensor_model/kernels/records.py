"""Records that group the arguments of the kernels."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from luxloop.arrays import Bools, Bytes, Floats, Ints

INVERSE_DEPTH, COSINE, INNER_INVERSE_DEPTH, INNER_COSINE = range(4)
"""Rows of `Rays.hit`."""
RANGE, POWER, WIDTH = range(3)
"""Rows of `Samples.value` (range, power) and of `ScanBuffers.echo` (all)."""
TARGET, SURFACE = range(2)
"""First rows of `Rays.hit_id`, `Samples.id`, `ScanBuffers.echo_id` and `DenseEchoes.echo_id`."""
INNER_SURFACE = 2
"""Last row of `Rays.hit_id`."""
BEAM = 2
"""Last row of `DenseEchoes.echo_id`."""
NONE = -1
"""Index in place of a plane where none is hit."""


class Fans(NamedTuple):
    """Fans of beams; the layers of a fan fire at the same azimuths. Fields as in `beams.BeamTable`."""

    fan_unit: Ints
    fan_row: Ints
    fan_azimuth: Floats
    fan_turn: Ints
    row_beam: Ints


class Grid(NamedTuple):
    """Directions of the rays of all beams, in the frames of the units.

    A beam has I rays over its height times J over its width, R in all; ray i J + j is in row i and column j. The L
    beams of a fan at one azimuth fire at once: L R rays, layer by layer.
    """

    half_width: Floats
    """(U,) half of a beam's width [rad]."""
    side: Floats
    """(U, 2, R) cosine and sine of a ray's azimuth less that of its beam."""
    fan_ray: Ints
    """(F,) fan f has the rays of its azimuths, one after the other, from fan_ray[f] on; equal fans share them."""
    azimuth: Floats
    """(B, 2) cosine and sine of the azimuth of each beam."""
    slope: Floats
    """(rays,) tangent of the elevation."""
    cos: Floats
    """(rays,) cosine of the elevation."""
    far: Floats
    """(rays,) inverse depth at the maximum range, 1 / (range x cosine) [1/m]."""
    refine: bool
    """If True, a beam whose corner rays decide its intersection with a solid is not traced further; the hits are the
    same."""


class Beams(NamedTuple):
    """Centre direction and sensitivity of each beam, in its unit's frame."""

    direction: Floats
    """(B, 4) cosine and sine of the azimuth, cosine and sine of the elevation."""
    gain: Floats
    """(B,)"""
    threshold: Floats
    """(B,) minimum power of an echo [1/m^2]."""
    time: Floats
    """(B,) firing time relative to the frame's time [s]."""


class BeamAxes(NamedTuple):
    """Centre direction of each beam, in its unit's frame."""

    unit: Bytes
    """(B,) unit of the beam."""
    number: npt.NDArray[np.int32]
    """(B,) index of the beam in its unit."""
    direction: Floats
    """(B, 3) unit vectors."""
    time: Floats
    """(B,) firing time relative to the frame's time [s]."""


class UnitPoses(NamedTuple):
    """Poses of the U units in the ego frame."""

    origin: Floats
    """(U, 3) [m]."""
    rotation: Floats
    """(U, 3, 3) ego = rotation unit."""


class Units(NamedTuple):
    """Poses of the U units in the ego frame, and their receivers; receiver fields as in `beams.UnitTable`."""

    origin: Floats
    rotation: Floats
    range_min: Floats
    range_max: Floats
    pulse_length: Floats
    pulse_growth: Floats
    echo_separation: Floats
    echoes_max: Ints


class BodyTilts(NamedTuple):
    """Tilts of A bodies; fields as in `bodies.Bodies`."""

    R_level_body: Floats
    ground_z: Floats


class Solids(NamedTuple):
    """Bodies in the ego frame; fields other than `motion` as in `bodies.Bodies`."""

    motion: Floats
    """(A, 8) pose x, y, yaw; velocity x, y; acceleration x, y; yaw rate."""
    bounds: Floats
    body_solid: Ints
    solid_plane: Ints
    solid_bounds: Floats
    solid_inner: Bools
    planes: Floats
    reflectivity: Floats
    transmission: Floats


class Ground(NamedTuple):
    """Heights of the ground on a grid: two triangles per cell, divided by the diagonal from node (0, 0)."""

    height: Floats
    """(X, Y) height of the nodes [m]; (0, 0) if the ground is the plane z = 0."""
    lid: Floats
    """(BX, BY, 3) plane on or above the nodes of each block of cells: rise per cell in x and in y, and height at node
    (0, 0) [m]."""
    pose: Floats
    """(7,) the ego's x and y on the grid [cells]; cosine and sine of its yaw over the cell's size [1/m]; its height
    [m]; size of a cell [m]; highest node [m]."""


class StaticScene(NamedTuple):
    """Ground and walls in the ego frame, fields as in `walls.Walls`, and optical properties of ground and air."""

    ends: Floats
    z: Floats
    reflectivity: Floats
    ground_reflectivity: float
    extinction: float
    """Of the air [1/m]."""
    ground: Ground


class EgoDrive(NamedTuple):
    """Ego motion over ground, in the axes of the ego frame at the frame's time [m/s, m/s^2, rad/s]."""

    vx: float
    vy: float
    ax: float
    ay: float
    yaw_rate: float


class Rays(NamedTuple):
    """State of the rays of a block of K successive azimuths of a fan during the cast: L beams of R rays at each.

    A ray starts at the origin of its azimuth and has the direction c x forward + s x left + slope x up, with cosine c
    and sine s of its azimuth less that of its beam. Hits are compared by inverse depth, 1 / (distance x cos), because
    the inverse depth of a plane is linear in s and slope, and c is almost constant.
    """

    line: Floats
    """(12, K) origin, forward, left and up in the ego frame, at the firing time of the azimuth."""
    side: Floats
    """(2, R) as in `Grid`."""
    slope: Floats
    """(K, L, R) as in `Grid`."""
    cos: Floats
    """(K, L, R) as in `Grid`."""
    far: Floats
    """(K, L, R) as in `Grid`."""
    hit: Floats
    """(4, K, L, R) rows `INVERSE_DEPTH` of the nearest hit or of the maximum range [1/m]; `COSINE` of its angle of
    incidence, not set for flat ground and nothing; the same of the inner surface, not set without one."""
    hit_id: Ints
    """(3, K, L, R) rows `TARGET`, the row of the body hit, GROUND, WALL or NOTHING; `SURFACE`, its plane or wall, not
    set for ground and nothing; `INNER_SURFACE`, the plane hit behind the pane on which the ray ends, or NONE."""
    on_ground: Floats
    """(K, L, R) inverse depth at which the ray meets uneven ground, or of the maximum range [1/m]; (0, 0, 0) if the
    ground is flat."""


class Receiver(NamedTuple):
    """Receiver of one unit; fields as in `beams.UnitTable`."""

    range_min: float
    pulse_length: float
    pulse_growth: float
    echo_separation: float
    echoes_max: int


class Samples(NamedTuple):
    """Light that returns to K beams of one layer: S samples, at most two per ray, beam after beam."""

    value: Floats
    """(2, S) rows `RANGE` [m] and `POWER` [1/m^2]."""
    id: Ints
    """(2, S) rows `TARGET` and `SURFACE`, as in `Rays.hit_id`."""
    order: Ints
    """(S,) sample of each sorted range."""
    start: Ints
    """(K + 1,) beam k has samples start[k] to start[k + 1]."""
    blocked: Bools
    """(K,) True if a ray of the beam hit something nearer than `range_min`, which gives no sample."""


class ScanBuffers(NamedTuple):
    """Output of a scan: a slot per beam, so that beams can be cast in any order."""

    echo: Floats
    """(3, B, E) range [m], power [1/m^2] and width [m] of up to E echoes of each beam."""
    echo_id: Ints
    """(2, B, E) target and surface of the echoes."""
    echoes: Ints
    """(B,) number of echoes of each beam."""
    lost: Bools
    """(B,) True for beams that hit something and have no echo."""
    lost_echo: Floats
    """(2, B) range [m] and value [1/m^2] of their highest returned power; range 0 if all hits are below range_min."""
    free_range: Floats
    """(B,) unobstructed range of each beam [m], or (0,) if it is not requested."""
    unit_hits: Ints
    """(U, A) rays that end on each body."""
    unit_hits_alone: Ints
    """(U, A) rays that would end on each body if it were alone on the ground."""


class DenseEchoes(NamedTuple):
    """N echoes in the order of the beams, and L lost beams."""

    echo: Floats
    """(3, N) as in `ScanBuffers`."""
    echo_id: Ints
    """(3, N) target, surface and beam."""
    lost_beam: Ints
    """(L,)"""
    lost_echo: Floats
    """(2, L) as in `ScanBuffers`."""


class Droplets(NamedTuple):
    """C clusters of droplets: spheres in the ego frame."""

    centre: Floats
    """(C, 3) [m]."""
    radius: Floats
    """(C,) [m]."""
    share: Floats
    """(C,) share of the beams through a cluster that get an echo."""
    tag: Ints
    """(C,) key of a cluster's random draws, below 2^32."""


class SurfaceHits(NamedTuple):
    """N returns; fields as in `returns.Returns`."""

    beam: Ints
    range: Floats
    target: Ints
    surface: Ints
    part: Bytes


class MovingPlanes(NamedTuple):
    """Surfaces of A bodies in the ego frame; fields as in `bodies.Bodies`."""

    pose: Floats
    yaw_rate: Floats
    planes: Floats


class Reflectance(NamedTuple):
    """Specular reflectance by part."""

    normal: Floats
    """Reflectance at normal incidence, F0 of Schlick (1994)."""
    quality: Floats
    """Share of the mirrored power that stays collimated."""


class RoughPlanes(NamedTuple):
    """Relief of the planes; fields as in `bodies.Bodies`."""

    planes_body: Floats
    plane_turn: Floats
    plane_relief: Floats
    plane_pivot: Floats
    relief_waves: Floats


class OutlinedBodies(NamedTuple):
    """Outlines and planes of A bodies; fields as in `bodies.Bodies`."""

    pose_ego: Floats
    planes_body: Floats
    plane_turn: Floats
    plane_pivot: Floats
    body_outline: Ints
    outline: Floats


class MountErrors(NamedTuple):
    """Errors of the poses and firing times of U units."""

    origin: Floats
    """(U, 3) nominal position in the ego frame [m]."""
    shift: Floats
    """(U, 3) true position less the nominal one [m]."""
    rotation: Floats
    """(U, 3, 3) from nominal to true directions."""
    delay: Floats
    """(U,) of the firing times [s]."""
