"""Limits of feasible motion on roads, and the extreme values of a run."""

from dataclasses import dataclass

import numpy as np

from luxloop.sim.kinematics import wrap_angle
from luxloop.sim.world import Kind

LIMITS = {
    "acceleration [m/s^2]": 10.0,
    "lateral acceleration [m/s^2]": 6.0,
    "yaw rate [rad/s]": 1.2,
    "jerk [m/s^3]": 60.0,
    "reversing [m/s]": 0.01,
    "velocity off the pose difference [m/s]": 0.15,
    "yaw rate off the yaw difference [rad/s]": 0.05,
    "deviation along [m]": 1.0,
    "deviation across [m]": 1.6,
    "creep of a standing body [m]": 0.0,
}
"""Requirements of the project, except the yaw rate, which is an estimate. Half a lane is 1.6 m."""

STANDING = 1e-9
"""[m/s] Bodies below this speed in two consecutive frames stand, and must not move between them."""


@dataclass
class Worst:
    """Largest value of one quantity."""

    value: float = 0.0
    frame: int = -1
    name: str = ""

    def take(self, values, frame, names):
        """Update the largest value."""
        if len(values) and np.max(values) > self.value:
            row = int(np.argmax(values))
            self.value, self.frame, self.name = float(values[row]), frame, str(names[row])


@dataclass
class Motion:
    """Motion of M bodies in one frame, including the ego as number 0."""

    id: np.ndarray
    name: np.ndarray
    on_foot: np.ndarray
    pose: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    yaw_rate: np.ndarray
    deviation: np.ndarray
    changes_lane: np.ndarray

    @classmethod
    def of(cls, frame):
        """Convert a `WorldFrame`."""
        ego, actors = frame.ego, frame.actors
        return cls(
            id=np.append(0, actors.id),
            name=np.append("ego", actors.name),
            on_foot=np.append(False, actors.kind == Kind.PEDESTRIAN),
            pose=np.vstack([ego.pose_world, actors.pose_world]),
            velocity=np.vstack([ego.velocity_world, actors.velocity_world]),
            acceleration=np.vstack([ego.acceleration_world, actors.acceleration_world]),
            yaw_rate=np.append(ego.yaw_rate, actors.yaw_rate),
            deviation=np.vstack([ego.deviation, actors.deviation]),
            changes_lane=np.append(ego.changes_lane, actors.changes_lane),
        )


def worst_motion(frames, dt):
    """Return the largest value of every quantity in `LIMITS` over a run, by name."""
    worst = {name: Worst() for name in LIMITS}
    before = None
    for frame in frames:
        now = Motion.of(frame)
        _within(worst, now, frame.index)
        if before is not None:
            _, old, new = np.intersect1d(before.id, now.id, return_indices=True)
            _between(worst, before, old, now, new, frame.index, dt)
        before = now
    return worst


def excesses(worst):
    """Return a line for each quantity beyond its limit."""
    return [
        f"{name}: {found.value:.3f} > {LIMITS[name]} in frame {found.frame}, {found.name}"
        for name, found in worst.items()
        if found.value > LIMITS[name]
    ]


def _within(worst, now, index):
    """Update the quantities of a single frame."""
    heading = np.column_stack([np.cos(now.pose[:, 2]), np.sin(now.pose[:, 2])])
    ahead = np.sum(now.velocity * heading, axis=1)
    lateral = now.acceleration[:, 1] * heading[:, 0] - now.acceleration[:, 0] * heading[:, 1]
    # pedestrians turn on the spot and step aside
    wheeled = ~now.on_foot
    keeps_lane = wheeled & ~now.changes_lane
    for name, values, rows in (
        ("acceleration [m/s^2]", np.hypot(*now.acceleration.T), slice(None)),
        ("lateral acceleration [m/s^2]", np.abs(lateral), wheeled),
        ("yaw rate [rad/s]", np.abs(now.yaw_rate), wheeled),
        ("reversing [m/s]", -ahead, wheeled),
        ("deviation along [m]", np.abs(now.deviation[:, 0]), slice(None)),
        ("deviation across [m]", np.abs(now.deviation[:, 1]), keeps_lane),
    ):
        worst[name].take(values[rows], index, now.name[rows])


def _between(worst, before, old, now, new, index, dt):
    """Update the quantities of two consecutive frames, for bodies in both."""
    moved = now.pose[new, :2] - before.pose[old, :2]
    mean = (now.velocity[new] + before.velocity[old]) / 2
    turned = wrap_angle(now.pose[new, 2] - before.pose[old, 2]) / dt
    stands = (np.hypot(*now.velocity[new].T) < STANDING) & (np.hypot(*before.velocity[old].T) < STANDING)
    jerk = (now.acceleration[new] - before.acceleration[old]) / dt
    rate = (now.yaw_rate[new] + before.yaw_rate[old]) / 2
    for name, values, rows in (
        ("jerk [m/s^3]", np.hypot(*jerk.T), slice(None)),
        ("velocity off the pose difference [m/s]", np.hypot(*(moved / dt - mean).T), slice(None)),
        ("yaw rate off the yaw difference [rad/s]", np.abs(turned - rate), slice(None)),
        ("creep of a standing body [m]", np.hypot(*moved.T), stands),
    ):
        worst[name].take(values[rows], index, now.name[new][rows])
