"""What the kernels work on, gathered by what it belongs to."""

from typing import NamedTuple

from sensor_model.arrays import Bools, Floats, Ints


class Fans(NamedTuple):
    """Beams that fire in the same directions but for their layers; fields as in `beams.BeamTable`."""

    fan_unit: Ints
    fan_row: Ints
    fan_azimuth: Floats
    fan_turn: Ints
    row_beam: Ints


class Grid(NamedTuple):
    """Directions of all rays in the frames of their units.

    A beam is I rays, one above the other, times J, side by side. So fan f has J columns an azimuth, M in all, and in
    each column n rays, I for each of its layers: ray i belongs to layer i // I, column m to azimuth m // J.
    """

    rises: int
    """I"""
    turns: int
    """J"""
    half_width: Floats
    """(U,) of a beam [rad]."""
    fan_column: Ints
    """(F + 1,) fan f has columns fan_column[f] to fan_column[f + 1]."""
    fan_ray: Ints
    """(F + 1,) likewise of its rays, column by column."""
    azimuth: Floats
    """(2, columns) cosine and sine."""
    slope: Floats
    """(rays,) tangent of the elevation."""
    cos: Floats
    """(rays,) cosine of the elevation."""
    far: Floats
    """(rays,) nearness of the farthest range, 1 / (range x cosine)."""


class Beams(NamedTuple):
    """Each beam's centre in its unit's frame, and how sensitive it is."""

    direction: Floats
    """(B, 4) cosine and sine of the azimuth, cosine and sine of the elevation."""
    gain: Floats
    """(B,)"""
    threshold: Floats
    """(B,) power that makes an echo [1/m^2]."""
    time: Floats
    """(B,) of firing, from the frame's [s]."""


class Units(NamedTuple):
    """Units (U,) in the ego frame, and their electronics; other fields as in `beams.UnitTable`."""

    origin: Floats
    rotation: Floats
    range_min: Floats
    range_max: Floats
    pulse_length: Floats
    pulse_growth: Floats
    echo_separation: Floats
    echoes_max: Ints


class Solids(NamedTuple):
    """Bodies in the ego frame; other fields as in `bodies.Bodies`."""

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


class StaticScene(NamedTuple):
    """Walls in the ego frame, fields as in `walls.Walls`; and how light comes back from ground and air."""

    ends: Floats
    z: Floats
    reflectivity: Floats
    ground_reflectivity: float
    extinction: float
    """Of the air [1/m]."""


class EgoDrive(NamedTuple):
    """The ego's motion over ground, in the axes of the ego frame."""

    vx: float
    vy: float
    ax: float
    ay: float
    yaw_rate: float


class Rays(NamedTuple):
    """The rays of a fan, n in each of its M columns, while they are cast.

    A ray starts at its column's origin and goes along forward + slope x up. How soon it meets something is its
    nearness, 1 / (distance x cos): of a plane that is linear in the slope.
    """

    column: Floats
    """(9, M) origin, forward and up, in the ego frame, when the column fires."""
    slope: Floats
    """(M, n) as in `Grid`."""
    cos: Floats
    """(M, n)"""
    far: Floats
    """(M, n)"""
    nearness: Floats
    """(M, n) of what the ray ends on, or of the farthest range [1/m]."""
    target: Ints
    """(M, n) what that is: a body, GROUND, WALL or NOTHING."""
    surface: Ints
    """(M, n) which plane or wall; not set for the others."""
    cosine: Floats
    """(M, n) of the angle of incidence there; not set for ground and nothing."""
    inner_surface: Ints
    """(M, n) plane that is met behind the pane on which the ray ends, or NONE."""
    inner_nearness: Floats
    """(M, n) of that; not set where there is none."""
    inner_cosine: Floats
    """(M, n) likewise."""
