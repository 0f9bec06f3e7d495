"""Recorded trajectories, split at gaps and interpolated between samples."""

from dataclasses import dataclass

import numpy as np

from luxloop import elementwise
from luxloop.arrays import Floats, Ints
from luxloop.sim.replay.recording import Recording
from luxloop.sim.source import TrafficInputError

FASTEST = 100.0
"""[m/s] Above road speeds: a faster step splits a trajectory, so that no body jumps across the map."""
JUMP = 4.0
"""[m] Additional tolerance of a step, since a recorded simulator may change lanes in one step."""
COURSE_FROM = 0.5
"""[m/s] The course of slower motion is unreliable: it may be noise of a standing body."""
ROUNDING = 1e-6
"""[s] Times that differ by less are equal."""


@dataclass(frozen=True, slots=True, eq=False)
class Trajectories:
    """L continuous trajectories of S samples. A road user that is absent for a while has two trajectories.

    Samples are ordered by trajectory, and by time within each.
    """

    user: Ints
    """(L,) road user of each trajectory, ascending; trajectories of one user are in order of time."""
    first: Ints
    """(L,) first sample."""
    last: Ints
    """(L,) last sample."""
    time: Floats
    """(S,) [s]."""
    pose: Floats
    """(S, 3) x [m], y [m], yaw [rad], the yaw unwrapped."""
    rate: Floats
    """(S, 3) derivative of the pose at the samples [m/s, rad/s]."""
    clock: tuple[float, float]
    """Earliest and latest time of all samples [s]."""
    key: Floats
    """(S,) sort key, ascending in time and from one trajectory to the next."""

    @classmethod
    def of(cls, recording: Recording, gap_s: float) -> "Trajectories":
        """Sort the samples of a recording, and start a new trajectory where they are more than `gap_s` apart.

        Raises
        ------
        TrafficInputError
            A road user has two different samples at the same time.
        """
        order = _without_repetitions(recording, np.lexsort((recording.time, recording.user)))
        user, time, pose = recording.user[order], recording.time[order], recording.pose[order].copy()
        _require_single(recording, order, user, time)
        step, distance = np.diff(time), elementwise.hypot(*np.diff(pose[:, :2], axis=0).T)
        cut = (np.diff(user) != 0) | (step > gap_s + ROUNDING) | (distance > FASTEST * step + JUMP)
        first = np.concatenate([[0], np.flatnonzero(cut) + 1])
        last = np.append(first[1:] - 1, len(time) - 1)
        step[cut] = np.inf
        unknown = np.isnan(pose[:, 2])
        pose[unknown, 2] = _course(pose[:, :2], time, first, last)[unknown]
        pose[:, 2] = np.unwrap(pose[:, 2])
        trajectory = np.repeat(np.arange(len(first)), last - first + 1)
        clock = (float(time.min()), float(time.max()))
        rate = _rates(pose, step, first, last)
        return cls(user[first], first, last, time, pose, rate, clock, _key(trajectory, time, clock))

    @property
    def begin(self) -> Floats:
        """(L,) time of the first sample [s]."""
        return self.time[self.first]

    @property
    def end(self) -> Floats:
        """(L,) time of the last sample [s]."""
        return self.time[self.last]

    def at(self, trajectory: Ints, time: float) -> tuple[Floats, Floats]:
        """Return poses (N, 3) and rates (N, 3) of trajectories (N,) at a time [s] that all of them contain.

        Interpolates by cubic Hermite polynomials; the pose is constant beyond the ends.
        """
        before = np.searchsorted(self.key, _key(trajectory, np.array(time), self.clock), side="right") - 1
        before = np.clip(before, self.first[trajectory], np.maximum(self.last[trajectory] - 1, self.first[trajectory]))
        after = np.minimum(before + 1, self.last[trajectory])
        h = np.where(after > before, self.time[after] - self.time[before], 1.0)[:, None]
        s = np.clip((time - self.time[before])[:, None] / h, 0.0, 1.0)
        start, end = self.pose[before], self.pose[after]
        rate, end_rate = self.rate[before], self.rate[after]
        pose = start + s * h * rate + s**2 * (3 * (end - start) - h * (2 * rate + end_rate))
        pose += s * s * s * (h * (rate + end_rate) - 2 * (end - start))
        slope = (1 - s) * (1 - 3 * s) * rate + s * (3 * s - 2) * end_rate + 6 * s * (1 - s) * (end - start) / h
        return pose, slope


def _without_repetitions(recording: Recording, order: Ints) -> Ints:
    """Return the rows `order`, sorted by user and time, without those that repeat the previous one exactly."""
    user, time, pose = recording.user[order], recording.time[order], recording.pose[order]
    same_pose = ((np.diff(pose, axis=0) == 0.0) | np.isnan(pose[1:]) & np.isnan(pose[:-1])).all(axis=1)
    repeats = (np.diff(user) == 0) & (np.diff(time) == 0.0) & same_pose
    return order[np.concatenate([[True], ~repeats])] if len(order) else order


def _require_single(recording: Recording, order: Ints, user: Ints, time: Floats) -> None:
    twice = np.flatnonzero((np.diff(user) == 0) & (np.diff(time) < ROUNDING))
    if len(twice):
        row = twice[0]
        one, other = sorted((order[row : row + 2] + 1).tolist())
        name = recording.users[user[row]].name
        raise TrafficInputError(f'"{name}" has two samples at {time[row]:g} s, rows {one} and {other}; keep one')


def _key(trajectory: Ints, time: Floats, clock: tuple[float, float]) -> Floats:
    start, end = clock
    return np.asarray(trajectory * (end - start + 1.0) + np.clip(time - start, 0.0, end - start), dtype=np.float64)


def _course(place: Floats, time: Floats, first: Ints, last: Ints) -> Floats:
    """Return the course of samples (S,) [rad], from the previous to the next sample.

    A standing body keeps its last course, or takes its next one; a body that never moves faces east.
    """
    sample = np.arange(len(time))
    begin, end = (np.repeat(bound, last - first + 1) for bound in (first, last))
    before, after = np.maximum(sample - 1, begin), np.minimum(sample + 1, end)
    distance = place[after] - place[before]
    moves = elementwise.hypot(*distance.T) > COURSE_FROM * (time[after] - time[before])
    held = np.maximum.accumulate(np.where(moves, sample, -1))
    coming = np.minimum.accumulate(np.where(moves, sample, len(time))[::-1])[::-1]
    source = np.where(held >= begin, held, np.where(coming <= end, coming, -1))
    return np.where(source >= 0, elementwise.atan2(distance[source, 1], distance[source, 0]), 0.0)


def _rates(pose: Floats, step: Floats, first: Ints, last: Ints) -> Floats:
    """Return the derivatives (S, 3) at samples `step` (S - 1,) [s] apart, infinite between trajectories.

    The derivatives follow Fritsch and Butland ("A Method for Constructing Local Monotone Piecewise Cubic Interpolants",
    SIAM Journal on Scientific and Statistical Computing 5, 1984): curves do not overshoot, so standing bodies do not
    oscillate and braking bodies do not roll back. At the ends, parabolas are used as far as they do not overshoot.
    """
    h = step[:, None]
    slope = np.diff(pose, axis=0) / h
    rate = np.zeros_like(pose)
    rate[1:-1] = _middle(h[:-1], h[1:], slope[:-1], slope[1:])
    for samples, inward in ((first, 0), (last, -1)):
        two = last > first
        at = samples[two]
        near = at + inward
        far = np.where(last[two] - first[two] > 1, near + (1 if inward == 0 else -1), near)
        rate[at] = _end(h[near], h[far], slope[near], slope[far])
    rate[first[first == last]] = 0.0
    return rate


def _middle(h: Floats, next_h: Floats, slope: Floats, next_slope: Floats) -> Floats:
    """Return the weighted harmonic mean of the slopes before and after a sample, 0 where their signs differ."""
    agree = slope * next_slope > 0
    before, after = np.where(agree, slope, 1.0), np.where(agree, next_slope, 1.0)
    with np.errstate(invalid="ignore"):  # infinite steps between trajectories
        share = (h + 2 * next_h) / (3 * (h + next_h))
        return np.where(agree, 1.0 / (share / before + (1 - share) / after), 0.0)


def _end(h: Floats, next_h: Floats, slope: Floats, next_slope: Floats) -> Floats:
    """Return the rate at an end of a trajectory, from the two nearest slopes."""
    rate = ((2 * h + next_h) * slope - h * next_slope) / (h + next_h)
    rate = np.where(rate * slope <= 0, 0.0, rate)
    return np.where((slope * next_slope <= 0) & (np.abs(rate) > 3 * np.abs(slope)), 3 * slope, rate)
