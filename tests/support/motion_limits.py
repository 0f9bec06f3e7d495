"""What no body on a road does, and how near a run of frames comes to it."""

from dataclasses import dataclass

import numpy as np

from sim.kinematics import wrap_angle
from sim.world import Kind

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
"""The issue's figures; half a lane is 1.6 m. The yaw rate's is ours: a degree and a half in half a second."""

STANDING = 1e-9
"""[m/s] Bodies this slow in two frames in a row stand, and must not move between them."""


@dataclass
class Worst:
    """The largest value of one quantity."""

    value: float = 0.0
    frame: int = -1
    name: str = ""

    def take(self, values, frame, names):
        """Keep the largest, if it is larger than what is known."""
        if len(values) and np.max(values) > self.value:
            row = int(np.argmax(values))
            self.value, self.frame, self.name = float(values[row]), frame, str(names[row])


@dataclass
class Motion:
    """The motion of M bodies in one frame, the ego among them as number 0."""

    id: np.ndarray
    name: np.ndarray
    walks: np.ndarray
    pose: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    yaw_rate: np.ndarray
    deviation: np.ndarray
    changes_lane: np.ndarray

    @classmethod
    def of(cls, frame):
        """Gather a `WorldFrame`."""
        ego, actors = frame.ego, frame.actors
        return cls(
            id=np.append(0, actors.id),
            name=np.append("ego", actors.name),
            walks=np.append(False, actors.kind == Kind.PEDESTRIAN),
            pose=np.vstack([ego.pose_world, actors.pose_world]),
            velocity=np.vstack([ego.velocity_world, actors.velocity_world]),
            acceleration=np.vstack([ego.acceleration_world, actors.acceleration_world]),
            yaw_rate=np.append(ego.yaw_rate, actors.yaw_rate),
            deviation=np.vstack([ego.deviation, actors.deviation]),
            changes_lane=np.append(ego.changes_lane, actors.changes_lane),
        )


def worst_motion(frames, dt):
    """Return the worst of every quantity in `LIMITS` over a run's frames, by name."""
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
    """Take in what one frame tells."""
    heading = np.column_stack([np.cos(now.pose[:, 2]), np.sin(now.pose[:, 2])])
    ahead = np.sum(now.velocity * heading, axis=1)
    lateral = now.acceleration[:, 1] * heading[:, 0] - now.acceleration[:, 0] * heading[:, 1]
    # people on foot turn on the spot and step aside
    wheels = ~now.walks
    keeps_lane = wheels & ~now.changes_lane
    for name, values, who in (
        ("acceleration [m/s^2]", np.hypot(*now.acceleration.T), slice(None)),
        ("lateral acceleration [m/s^2]", np.abs(lateral), wheels),
        ("yaw rate [rad/s]", np.abs(now.yaw_rate), wheels),
        ("reversing [m/s]", -ahead, wheels),
        ("deviation along [m]", np.abs(now.deviation[:, 0]), slice(None)),
        ("deviation across [m]", np.abs(now.deviation[:, 1]), keeps_lane),
    ):
        worst[name].take(values[who], index, now.name[who])


def _between(worst, before, old, now, new, index, dt):
    """Take in what two frames in a row tell of those who are in both."""
    moved = now.pose[new, :2] - before.pose[old, :2]
    mean = (now.velocity[new] + before.velocity[old]) / 2
    turned = wrap_angle(now.pose[new, 2] - before.pose[old, 2]) / dt
    stands = (np.hypot(*now.velocity[new].T) < STANDING) & (np.hypot(*before.velocity[old].T) < STANDING)
    jerk = (now.acceleration[new] - before.acceleration[old]) / dt
    rate = (now.yaw_rate[new] + before.yaw_rate[old]) / 2
    for name, values, who in (
        ("jerk [m/s^3]", np.hypot(*jerk.T), slice(None)),
        ("velocity off the pose difference [m/s]", np.hypot(*(moved / dt - mean).T), slice(None)),
        ("yaw rate off the yaw difference [rad/s]", np.abs(turned - rate), slice(None)),
        ("creep of a standing body [m]", np.hypot(*moved.T), stands),
    ):
        worst[name].take(values[who], index, now.name[new][who])
