"""Analytic motions of scripted bodies, with exact rates. Course and heading are equal.

Each motion starts at the origin along x; `state_at` concatenates them from a start pose. Their `kind` has no default,
so that a scenario file with a missing `kind` is not matched to another motion by its remaining keys.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from luxloop import elementary, elementwise
from luxloop.arrays import Floats
from luxloop.sim.physical.lane_change import minimum_jerk


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """Pose and rates of one body at one time."""

    pose: Floats
    """(3,) x [m], y [m], yaw [rad], unwrapped."""
    velocity: Floats
    """(2,) [m/s]."""
    acceleration: Floats
    """(2,) [m/s^2]."""
    yaw_rate: float
    """[rad/s]."""

    def seen_from(self, start: Floats) -> "State":
        """Transform from the motion's frame to the frame in which it starts at the pose `start` (3,)."""
        cos, sin = elementary.cos(start[2]), elementary.sin(start[2])
        rotation = np.array([[cos, -sin], [sin, cos]])
        position = start[:2] + elementwise.product(rotation, self.pose[:2])
        return State(
            pose=np.append(position, start[2] + self.pose[2]),
            velocity=elementwise.product(rotation, self.velocity),
            acceleration=elementwise.product(rotation, self.acceleration),
            yaw_rate=self.yaw_rate,
        )


def _along_x(distance: float, speed: float, acceleration: float) -> State:
    return State(np.array([distance, 0.0, 0.0]), np.array([speed, 0.0]), np.array([acceleration, 0.0]), 0.0)


@dataclass(frozen=True, slots=True)
class Static:
    """Stand still."""

    kind: Literal["static"]
    duration_s: float | None = None
    """[s] Until the next motion begins; omit it for the last. The same for every motion."""

    def at(self, time: float) -> State:
        """Return the state at a time [s] since the motion began."""
        del time
        return _along_x(0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Spin:
    """Turn on the spot, which no car can do: shows all sides of a standing body."""

    kind: Literal["spin"]
    rate_deg_per_s: float
    """[deg/s] Counter-clockwise positive."""
    duration_s: float | None = None
    """[s] See `Static`."""

    def at(self, time: float) -> State:
        """Return the state at a time [s] since the motion began."""
        rate = math.radians(self.rate_deg_per_s)
        return State(np.array([0.0, 0.0, rate * time]), np.zeros(2), np.zeros(2), rate)


@dataclass(frozen=True, slots=True)
class Straight:
    """Drive straight at constant acceleration; braking ends at standstill."""

    kind: Literal["straight"]
    speed_mps: float
    """[m/s] At the start; negative values drive backwards."""
    acceleration_mps2: float = 0.0
    """[m/s^2] Along the heading: negative values brake, positive ones brake driving backwards."""
    duration_s: float | None = None
    """[s] See `Static`."""

    def at(self, time: float) -> State:
        """Return the state at a time [s] since the motion began."""
        v, a = self.speed_mps, self.acceleration_mps2
        if (a < 0 <= v or v < 0 < a) and time >= -v / a:
            return _along_x(-v * v / (2 * a), 0.0, 0.0)
        return _along_x(v * time + a * time**2 / 2, v + a * time, a)


@dataclass(frozen=True, slots=True)
class Arc:
    """Drive a circle at constant speed."""

    kind: Literal["arc"]
    speed_mps: float
    """[m/s] Negative values drive backwards."""
    radius_m: float
    """[m] Positive turns left, negative right."""
    duration_s: float | None = None
    """[s] See `Static`."""

    def __post_init__(self) -> None:
        if self.radius_m == 0:
            raise ValueError("an arc needs a radius_m other than 0")

    def at(self, time: float) -> State:
        """Return the state at a time [s] since the motion began."""
        v, r = self.speed_mps, self.radius_m
        yaw = v / r * time
        cos, sin = elementary.cos(yaw), elementary.sin(yaw)
        return State(
            pose=np.array([r * sin, r * (1 - cos), yaw]),
            velocity=v * np.array([cos, sin]),
            acceleration=v * v / r * np.array([-sin, cos]),
            yaw_rate=v / r,
        )


@dataclass(frozen=True, slots=True)
class StopAndGo:
    """Start and stop repeatedly: v = V/2 (1 - cos(2 pi t / go)) while moving, then stand for `stop_s`."""

    kind: Literal["stop-and-go"]
    peak_speed_mps: float
    """[m/s] V, reached in the middle of each interval of motion."""
    go_s: float
    """[s] Interval of motion, from standstill to standstill."""
    stop_s: float
    """[s] Interval of standstill."""
    duration_s: float | None = None
    """[s] See `Static`."""

    def __post_init__(self) -> None:
        if self.peak_speed_mps < 0 or self.go_s <= 0 or self.stop_s < 0:
            raise ValueError("stop-and-go needs peak_speed_mps and stop_s of at least 0 and a positive go_s")

    def at(self, time: float) -> State:
        """Return the state at a time [s] since the motion began."""
        v, go = self.peak_speed_mps, self.go_s
        rounds, elapsed = divmod(time, go + self.stop_s)
        going = min(elapsed, go)
        phase = 2 * math.pi * going / go
        distance = rounds * v * go / 2 + v / 2 * (going - go / (2 * math.pi) * elementary.sin(phase))
        if elapsed >= go:
            return _along_x(distance, 0.0, 0.0)
        return _along_x(distance, v / 2 * (1 - elementary.cos(phase)), v * math.pi / go * elementary.sin(phase))


@dataclass(frozen=True, slots=True)
class LaneChange:
    """Change lanes by the quintic y = d (10 s^3 - 15 s^4 + 6 s^5), s = t / T; then drive straight on.

    The speed along x is constant. The quintic is the minimum-jerk lateral motion between two straights.
    """

    kind: Literal["lane-change"]
    speed_mps: float
    """[m/s] Along the lane."""
    offset_m: float
    """[m] d, positive to the left."""
    change_s: float
    """[s] T."""
    duration_s: float | None = None
    """[s] See `Static`."""

    def __post_init__(self) -> None:
        if self.speed_mps <= 0 or self.change_s <= 0:
            raise ValueError("a lane change needs a positive speed_mps and change_s")

    def at(self, time: float) -> State:
        """Return the state at a time [s] since the motion began."""
        v, d, period = self.speed_mps, self.offset_m, self.change_s
        s = min(time / period, 1.0)
        rest = 1.0 - s
        y = d * minimum_jerk(s)
        v_y = d / period * 30 * s * s * rest * rest
        a_y = d / period**2 * 60 * s * rest * (rest - s)
        return State(
            pose=np.array([v * time, y, elementary.atan2(v_y, v)]),
            velocity=np.array([v, v_y]),
            acceleration=np.array([0.0, a_y]),
            yaw_rate=v * a_y / (v * v + v_y * v_y),
        )


Motion = Static | Spin | Straight | Arc | StopAndGo | LaneChange


def require_sequence(motions: Sequence[Motion]) -> None:
    """Raise ValueError if there is no motion, or if one before the last has no positive duration."""
    if not motions:
        raise ValueError("motion is empty; omit it for a standing body")
    if any(not (motion.duration_s or 0) > 0 for motion in motions[:-1]):
        raise ValueError("each motion but the last needs a positive duration_s")


def state_at(motions: Sequence[Motion], start: Floats, time: float) -> State:
    """Return the state of a body at a time [s] since it began its motions at the pose `start` (3,).

    Velocities may differ where motions meet: the state at that time is the state of the later motion.
    """
    for motion in motions[:-1]:
        duration = motion.duration_s or 0.0
        if time < duration:
            return motion.at(time).seen_from(start)
        start = motion.at(duration).seen_from(start).pose
        time -= duration
    return motions[-1].at(time).seen_from(start)
