"""Warnings of recorded motions that no vehicle can follow, so that the truth leaves the recording."""

import numpy as np

from luxloop.sim.arrays import Bools
from luxloop.sim.physical.limits import YAW_RATE_ON_WHEELS
from luxloop.sim.replay.recording import Recording
from luxloop.sim.replay.trajectories import Trajectories
from luxloop.sim.world import Kind

FASTER_MPS = 2.0
"""[m/s] The course of slower motion may be noise."""
SLIP = np.radians(45.0)
"""[rad] Largest angle between heading and course, forwards or backwards."""
SLIPPING_S = 1.0
"""[s] Shorter slips are noise of the recording."""
TURN = np.radians(90.0)
"""[rad] Largest turn between two samples that are too close for it; a course without headings does so in reversing."""
NAMED = 3
"""Road users that a warning names."""


def contradictions(recording: Recording, trajectories: Trajectories) -> tuple[str, ...]:
    """Return warnings of vehicles whose heading differs from their course, and of those that turn on the spot."""
    count = trajectories.last - trajectories.first + 1
    user = np.repeat(trajectories.user, count)
    on_wheels = np.array([each.kind != Kind.PEDESTRIAN for each in recording.users])[user]
    step = np.append(np.diff(trajectories.time), 0.0)
    step[trajectories.last] = 0.0
    course = np.arctan2(trajectories.rate[:, 1], trajectories.rate[:, 0])
    slip = np.abs((trajectories.pose[:, 2] - course + 0.5 * np.pi) % np.pi - 0.5 * np.pi)
    slips = on_wheels & (np.hypot(*trajectories.rate[:, :2].T) > FASTER_MPS) & (slip > SLIP)
    slipping_s = np.bincount(user, weights=slips * step, minlength=len(recording.users))
    turn = np.abs(np.diff(trajectories.pose[:, 2], append=0.0))
    turns = on_wheels & (step > 0.0) & (turn > TURN) & (turn > 2.0 * YAW_RATE_ON_WHEELS * step)
    said = (
        (
            slipping_s >= SLIPPING_S,
            "head more than 45 degrees away from their course; the truth follows their positions",
        ),
        (
            np.isin(np.arange(len(recording.users)), user[turns]),
            "turn on the spot; give headings of those that reverse",
        ),
    )
    return tuple(f"{_named(recording, users)} {what}" for users, what in said if users.any())


def _named(recording: Recording, users: Bools) -> str:
    names = [f'"{recording.users[row].name}"' for row in np.flatnonzero(users).tolist()]
    more = [f"{len(names) - NAMED} more"] if len(names) > NAMED else []
    return ", ".join([*names[:NAMED], *more])
