"""Checks of a recording: numbers far beyond road traffic, and headings of vehicles against their motion.

Such numbers mean wrong units or a damaged file.
"""

from dataclasses import dataclass

import numpy as np

from luxloop import elementwise
from luxloop.arrays import Bools, Floats, Ints
from luxloop.sim.physical.limits import YAW_RATE_ON_WHEELS
from luxloop.sim.replay.recording import Recording
from luxloop.sim.replay.trajectories import Trajectories
from luxloop.sim.source import TrafficInputError
from luxloop.sim.world import Kind

LATEST_S = 1e11
"""[s] Clocks count from 1970 at most: 2e9 s. Milliseconds and shorter units are larger."""
FARTHEST_M = 1e8
"""[m] Coordinates of any projection of the Earth are smaller."""
LARGEST_YAW = 1e4
"""[rad] Yaws may be unwrapped."""
SMALLEST_M, LARGEST_M = 0.05, 200.0
"""[m] Sizes of road users."""


def require_plausible(recording: Recording) -> None:
    """Check times, positions, yaws and sizes.

    Raises
    ------
    TrafficInputError
        One is not finite or out of range; the message names the road user.
    """
    x, y, yaw = recording.pose.T
    _require(recording, "time", recording.time, np.abs(recording.time) <= LATEST_S, f"within {LATEST_S:g} s")
    for name, values in (("x", x), ("y", y)):
        _require(recording, name, values, np.abs(values) <= FARTHEST_M, f"within {FARTHEST_M:g} m")
    _require(recording, "yaw", yaw, np.isnan(yaw) | (np.abs(yaw) <= LARGEST_YAW), f"within {LARGEST_YAW:g} rad")
    for user in recording.users:
        if not all(SMALLEST_M <= side <= LARGEST_M for side in user.size):
            sides = " x ".join(f"{side:g}" for side in user.size)
            raise TrafficInputError(
                f'"{user.name}" is {sides} m large; should be {SMALLEST_M:g} to {LARGEST_M:g} m along each side'
            )


def _require(recording: Recording, name: str, values: Floats, good: Bools, remedy: str) -> None:
    if not good.all():
        at = int(np.argmin(good))
        user = recording.users[recording.user[at]].name
        raise TrafficInputError(f'"{user}": {name} = {values[at]:g}: should be a number {remedy}; correct the file')


FASTER_MPS = 2.0
"""[m/s] The course of slower motion may be noise."""
SLIP = np.radians(45.0)
"""[rad] Largest angle between heading and course, forwards or backwards."""
SLIPPING_S = 1.0
"""[s] Shorter slips are noise of the recording."""
TURN = np.radians(90.0)
"""[rad] Largest turn between two samples that are too close for it; a course without headings does so in reversing."""
BACKWARDS_MPS = (0.5, 8.0)
"""[m/s] Range of speeds of a vehicle that drives backwards: slower is noise, faster a wrong heading."""
NAMED = 3
"""Road users that a warning names."""


@dataclass(frozen=True, slots=True)
class _Headings:
    """Headings of M samples against their motion."""

    user: Ints
    """(M,) row of the road user."""
    on_wheels: Bools
    """(M,) True for all but pedestrians."""
    step: Floats
    """(M,) time until the next sample [s], 0 at the last one of a trajectory."""
    ahead: Floats
    """(M,) speed along the heading [m/s], negative backwards."""
    slips: Bools
    """(M,) True for vehicles that head away from their course, forwards or backwards."""

    @classmethod
    def of(cls, recording: Recording, trajectories: Trajectories) -> "_Headings":
        user = np.repeat(trajectories.user, trajectories.last - trajectories.first + 1)
        on_wheels = np.array([each.kind != Kind.PEDESTRIAN for each in recording.users])[user]
        step = np.append(np.diff(trajectories.time), 0.0)
        step[trajectories.last] = 0.0
        (x, y), yaw = trajectories.rate[:, :2].T, trajectories.pose[:, 2]
        slip = np.abs((yaw - elementwise.atan2(y, x) + 0.5 * np.pi) % np.pi - 0.5 * np.pi)
        slips = on_wheels & (elementwise.hypot(x, y) > FASTER_MPS) & (slip > SLIP)
        return cls(user, on_wheels, step, x * elementwise.cos(yaw) + y * elementwise.sin(yaw), slips)

    def last(self, samples: Bools, users: int) -> Bools:
        """Return the road users for whom a mask of samples holds for a second."""
        return np.bincount(self.user, weights=samples * self.step, minlength=users) >= SLIPPING_S


def reversing(recording: Recording, trajectories: Trajectories) -> Bools:
    """(N,) True for vehicles that drive backwards for a second, by headings that do not contradict their motion."""
    found, users = _Headings.of(recording, trajectories), len(recording.users)
    slow, fast = BACKWARDS_MPS
    wrong = found.last(found.slips, users) | found.last(found.on_wheels & (found.ahead < -fast), users)
    return found.last(found.on_wheels & ~found.slips & (found.ahead < -slow), users) & ~wrong


def contradictions(recording: Recording, trajectories: Trajectories) -> tuple[str, ...]:
    """Return warnings of vehicles whose heading differs from their course, and of those that turn on the spot."""
    found, users = _Headings.of(recording, trajectories), len(recording.users)
    user, on_wheels, step = found.user, found.on_wheels, found.step
    turn = np.abs(np.diff(trajectories.pose[:, 2], append=0.0))
    turns = on_wheels & (step > 0.0) & (turn > TURN) & (turn > 2.0 * YAW_RATE_ON_WHEELS * step)
    said = (
        (
            found.last(found.slips, users),
            "head more than 45 degrees away from their course; the truth follows their positions",
        ),
        (
            found.last(on_wheels & (found.ahead < -BACKWARDS_MPS[1]), users),
            "drive backwards at more than 8 m/s by their headings; the truth heads along their course",
        ),
        (
            np.isin(np.arange(users), user[turns]),
            "turn on the spot; give headings of those that reverse",
        ),
    )
    return tuple(f"{_named(recording, named)} {what}" for named, what in said if named.any())


def _named(recording: Recording, users: Bools) -> str:
    names = [f'"{recording.users[row].name}"' for row in np.flatnonzero(users).tolist()]
    more = [f"{len(names) - NAMED} more"] if len(names) > NAMED else []
    return ", ".join([*names[:NAMED], *more])
