"""Vehicles of a recording at regular moments, to choose the ego."""

from collections.abc import Iterator

import numpy as np

from luxloop import elementwise
from luxloop.sim.candidates.candidates import Body, Moment
from luxloop.sim.replay.recording import Recording
from luxloop.sim.replay.trajectories import ROUNDING, Trajectories
from luxloop.sim.world import VEHICLE_KINDS, Kind

INTERVAL_S = 1.0
"""[s] Time between two moments."""


def moments(recording: Recording, gap_s: float, interval_s: float = INTERVAL_S) -> Iterator[Moment]:
    """Yield the road users of a recording at regular moments, people included.

    A road user that is absent for a while is a body per trajectory.

    Parameters
    ----------
    recording
        The recording.
    gap_s
        As `ReplayTraffic.gap_s`.
    interval_s
        Time between two moments [s].
    """
    trajectories = Trajectories.of(recording, gap_s)
    number = np.full(len(trajectories.user), -1)
    begin, end = trajectories.clock
    for time in np.arange(begin, end + ROUNDING, interval_s):
        rows = np.flatnonzero((trajectories.begin <= time + ROUNDING) & (time < trajectories.end - ROUNDING))
        new = rows[number[rows] < 0]
        number[new] = number.max(initial=-1) + 1 + np.arange(len(new))
        pose, rate = trajectories.at(rows, time)
        yield Moment(
            time=float(time),
            new=[_body(recording, int(trajectories.user[row])) for row in new],
            body=number[rows],
            pose=pose,
            speed=elementwise.hypot(*rate[:, :2].T),
        )


def _body(recording: Recording, number: int) -> Body:
    user = recording.users[number]
    graded = user.kind in VEHICLE_KINDS
    kind = user.kind.name.lower().replace("_", "-")
    return Body(user.name, kind, user.size[:2], graded, not graded or user.kind == Kind.MOTORCYCLE)
