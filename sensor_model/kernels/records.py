"""What the kernels work on, gathered by what it belongs to."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]


class Fans(NamedTuple):
    """Beams that fire in the same directions but for their layers; fields as in `beams.BeamTable`."""

    fan_unit: Ints
    fan_row: Ints
    fan_azimuth: Floats
    fan_turn: Ints
    row_beam: Ints


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
    rise: Floats
    """(U, I, 2) cosine and sine of the elevation of a beam's rays, from its centre."""
    turn: Floats
    """(U, J, 2) of their azimuth."""


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


class Surroundings(NamedTuple):
    """Walls in the ego frame, fields as in `walls.Walls`; and how light comes back from ground and air."""

    ends: Floats
    z: Floats
    reflectivity: Floats
    ground_reflectivity: float
    extinction: float
    """Of the air [1/m]."""


class Drive(NamedTuple):
    """The ego's motion over ground, in the axes of the ego frame."""

    vx: float
    vy: float
    ax: float
    ay: float
    yaw_rate: float
