"""Records of the kernels: tables and ring buffers with a row for each of S road users."""

from typing import NamedTuple

from luxloop.arrays import Bools, Floats, Ints

X, Y, YAW, SPEED, ACCELERATION, YAW_RATE, YAW_ACCELERATION, LAG, TRAILER_YAW, TRAILER_RATE = range(10)
"""Columns of `BodyStates.state`. The position is that of the rear axle (of a tractor, its drive axle); speed and
acceleration are longitudinal; the lag is the time by which the front is behind its path [s]. Yaws are not wrapped."""


NO_FRAME = -9
"""Marker for an unused frame; it is neither a frame number nor one of the two before the first."""


class BodyDimensions(NamedTuple):
    """Dimensions of bodies [m]."""

    length: Floats
    """(S,)"""
    front_offset: Floats
    """(S,) from the rear axle to the front point that follows the path."""
    limit_offset: Floats
    """(S,) from the rear axle to the point whose acceleration is limited."""
    yaw_rate_max: Floats
    """(S,) [rad/s]."""
    motion_offset: Floats
    """(S,) from the rear axle to the point whose motion is computed: the box centre of a rigid body, the kingpin of a
    tractor, the front of a tram or train."""
    kingpin_offset: Floats
    """(S,) from a tractor's rear axle forward to the kingpin."""
    trailer_wheelbase: Floats
    """(S,) from the kingpin back to the trailer's axles; 0 for rigid bodies."""
    centre_offset: Floats
    """(S,) from the kingpin to the box centre of the whole straight vehicle; negative, since it is behind."""


class RawHistory(NamedTuple):
    """Raw simulator output of the last L frames. Frame f is in row f % L of each body, if `frame` confirms it."""

    frame: Ints
    """(S, L) frame stored in the row, or `NO_FRAME`."""
    changes_lane: Bools
    """(S, L) mask of frames in which a lane change is being spread."""
    raw: Floats
    """(S, L, 3) the followed point's x [m], y [m], and the body's yaw [rad]."""
    path: Floats
    """(S, L, 3) the same with spread lane changes and, for a rolling body, the course instead of the yaw [rad]."""
    speed: Floats
    """(S, L) [m/s]."""


class BodyStates(NamedTuple):
    """States of rolling bodies in the last final frame."""

    state: Floats
    """(S, 10) columns see `X`."""
    last_frame: Ints
    """(S,) last final frame of each body, or `NO_FRAME`."""
    first_frame: Ints
    """(S,) first frame of the uninterrupted sequence that ends there."""
    trail: Floats
    """(S, K, 6) smoothed position, velocity and acceleration of the followed point; frame f is in row f % K."""
