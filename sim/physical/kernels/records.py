"""What the kernels work on: tables and rings of frames, a row for each of S road users."""

from typing import NamedTuple

from sim.arrays import Bools, Floats, Ints

X, Y, YAW, SPEED, ACCELERATION, YAW_RATE, YAW_ACCELERATION, LAG, TRAILER_YAW, TRAILER_RATE = range(10)
"""Columns of `Led.state`. The place is the rear axle's (of a tractor, its drive axle's); speed and acceleration are
those along the body; the lag is the time by which the front is behind its path [s]. Yaws are not wrapped."""


NEVER = -9
"""Stands for a frame that has not been, nor the two before the first."""


class Builds(NamedTuple):
    """Bodies; metres."""

    length: Floats
    """(S,)"""
    lead: Floats
    """(S,) from the rear axle to the point at the front that leads."""
    arm: Floats
    """(S,) from the rear axle to the point whose acceleration is limited."""
    yaw_rate_max: Floats
    """(S,) [rad/s]."""
    kingpin: Floats
    """(S,) from a tractor's rear axle to the kingpin ahead of it."""
    base: Floats
    """(S,) from the kingpin back to the trailer's axles; 0 for whatever does not bend."""
    box: Floats
    """(S,) from the kingpin to the box centre of the whole vehicle, were it straight; negative, since it is behind."""


class Said(NamedTuple):
    """What the simulator said in the last L frames; frame f is in row f % L of each body, if it is that one's."""

    frame: Ints
    """(S, L) which frame the row is of, or `NEVER`."""
    changes_lane: Bools
    """(S, L) a jump is being spread."""
    raw: Floats
    """(S, L, 3) the leading point's x [m], y [m], and the body's yaw [rad]."""
    path: Floats
    """(S, L, 3) the same with jumps spread, and in place of the yaw, where a front leads, its course [rad]."""
    speed: Floats
    """(S, L) [m/s]."""


class Led(NamedTuple):
    """Bodies that are led, as of the last settled frame."""

    state: Floats
    """(S, 10) see `X` and those after it."""
    settled: Ints
    """(S,) the last frame in which each was settled, or `NEVER`."""
    since: Ints
    """(S,) the first of the frames in a row in which it was."""
    trail: Floats
    """(S, K, 6) smoothed place, velocity and acceleration of the leading point in settled frames; f is in row f % K."""
