"""Recorded motions that can be asked for any time: samples in order, cut where they leave gaps, with curves between."""

from dataclasses import dataclass

import numpy as np

from sim.arrays import Floats, Ints
from sim.replay.recording import Recording
from sim.source import TrafficInputError

FASTEST = 100.0
"""[m/s] Faster than anything on a road: what moves so was carried there, and does not streak across the map."""
JUMP = 4.0
"""[m] that a change of place may have on top, since a recorded simulator may change lanes in one step."""
COURSE_FROM = 0.5
"""[m/s] Slower motion tells no course: it may be the noise of who stands."""
ROUNDING = 1e-6
"""[s] Times that differ by less are the same."""


@dataclass(frozen=True, slots=True, eq=False)
class Trajectories:
    """L unbroken motions of S samples. Who vanishes in between and comes back has two lives."""

    user: Ints
    """(L,) whose life it is, ascending; the lives of one user by time."""
    first: Ints
    """(L,) first sample."""
    last: Ints
    """(L,) last sample."""
    time: Floats
    """(S,) [s], by life and ascending therein."""
    pose: Floats
    """(S, 3) x [m], y [m], yaw [rad], the yaw without jumps by whole turns."""
    rate: Floats
    """(S, 3) its derivative at the samples [m/s, rad/s]."""
    clock: tuple[float, float]
    """Earliest and latest time of all [s]."""
    key: Floats
    """(S,) ascending in time, and from one life to the next."""

    @classmethod
    def of(cls, recording: Recording, gap_s: float) -> "Trajectories":
        """Sort the samples of a recording into lives; where samples are further apart than `gap_s`, a new one begins.

        Raises
        ------
        TrafficInputError
            Somebody is in two places at a time.
        """
        order = np.lexsort((recording.time, recording.user))
        user, time, pose = recording.user[order], recording.time[order], recording.pose[order].copy()
        _require_single(recording, order, user, time)
        step, way = np.diff(time), np.hypot(*np.diff(pose[:, :2], axis=0).T)
        cut = (np.diff(user) != 0) | (step > gap_s + ROUNDING) | (way > FASTEST * step + JUMP)
        first = np.concatenate([[0], np.flatnonzero(cut) + 1])
        last = np.append(first[1:] - 1, len(time) - 1)
        step[cut] = np.inf
        unknown = np.isnan(pose[:, 2])
        pose[unknown, 2] = _course(pose[:, :2], time, first, last)[unknown]
        pose[:, 2] = np.unwrap(pose[:, 2])
        life = np.repeat(np.arange(len(first)), last - first + 1)
        clock = (float(time.min()), float(time.max()))
        rate = _rates(pose, step, first, last)
        return cls(user[first], first, last, time, pose, rate, clock, _key(life, time, clock))

    @property
    def begin(self) -> Floats:
        """(L,) time of the first sample [s]."""
        return self.time[self.first]

    @property
    def end(self) -> Floats:
        """(L,) time of the last sample [s]."""
        return self.time[self.last]

    def at(self, life: Ints, time: float) -> tuple[Floats, Floats]:
        """Return poses (N, 3) and their rates (N, 3) of lives (N,) at a time [s] that all of them contain.

        Between samples runs the cubic of Hermite; outside of a life stays its end.
        """
        here = np.searchsorted(self.key, _key(life, np.array(time), self.clock), side="right") - 1
        here = np.clip(here, self.first[life], np.maximum(self.last[life] - 1, self.first[life]))
        there = np.minimum(here + 1, self.last[life])
        h = np.where(there > here, self.time[there] - self.time[here], 1.0)[:, None]
        s = np.clip((time - self.time[here])[:, None] / h, 0.0, 1.0)
        start, end = self.pose[here], self.pose[there]
        rate, end_rate = self.rate[here], self.rate[there]
        pose = start + s * h * rate + s**2 * (3 * (end - start) - h * (2 * rate + end_rate))
        pose += s**3 * (h * (rate + end_rate) - 2 * (end - start))
        slope = (1 - s) * (1 - 3 * s) * rate + s * (3 * s - 2) * end_rate + 6 * s * (1 - s) * (end - start) / h
        return pose, slope


def _require_single(recording: Recording, order: Ints, user: Ints, time: Floats) -> None:
    twice = np.flatnonzero((np.diff(user) == 0) & (np.diff(time) < ROUNDING))
    if len(twice):
        row = twice[0]
        one, other = sorted((order[row : row + 2] + 1).tolist())
        name = recording.users[user[row]].name
        raise TrafficInputError(f'"{name}" has two samples at {time[row]:g} s, rows {one} and {other}; keep one')


def _key(life: Ints, time: Floats, clock: tuple[float, float]) -> Floats:
    start, end = clock
    return np.asarray(life * (end - start + 1.0) + np.clip(time - start, 0.0, end - start), dtype=np.float64)


def _course(place: Floats, time: Floats, first: Ints, last: Ints) -> Floats:
    """Return where samples (S,) move to [rad], from the one before to the one after.

    Who stands keeps its last course, or looks where it will go; who never moves looks east.
    """
    sample = np.arange(len(time))
    begin, end = (np.repeat(bound, last - first + 1) for bound in (first, last))
    before, after = np.maximum(sample - 1, begin), np.minimum(sample + 1, end)
    way = place[after] - place[before]
    moves = np.hypot(*way.T) > COURSE_FROM * (time[after] - time[before])
    held = np.maximum.accumulate(np.where(moves, sample, -1))
    coming = np.minimum.accumulate(np.where(moves, sample, len(time))[::-1])[::-1]
    source = np.where(held >= begin, held, np.where(coming <= end, coming, -1))
    return np.where(source >= 0, np.arctan2(way[source, 1], way[source, 0]), 0.0)


def _rates(pose: Floats, step: Floats, first: Ints, last: Ints) -> Floats:
    """Return the derivatives (S, 3) at samples `step` (S - 1,) [s] apart, infinity between lives.

    Those of Fritsch and Butland ("A Method for Constructing Local Monotone Piecewise Cubic Interpolants", SIAM Journal
    on Scientific and Statistical Computing 5, 1984): curves do not overshoot, so that who stands does not rock and who
    brakes does not roll back. At the ends, parabolas as far as they do not overshoot.
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
    """Return the weighted harmonic mean of slopes before and after a sample, 0 where they disagree in sign."""
    agree = slope * next_slope > 0
    before, after = np.where(agree, slope, 1.0), np.where(agree, next_slope, 1.0)
    with np.errstate(invalid="ignore"):  # at infinity, between lives
        share = (h + 2 * next_h) / (3 * (h + next_h))
        return np.where(agree, 1.0 / (share / before + (1 - share) / after), 0.0)


def _end(h: Floats, next_h: Floats, slope: Floats, next_slope: Floats) -> Floats:
    """Return the rate at an end of a life, from the slopes next to it and next but one."""
    rate = ((2 * h + next_h) * slope - h * next_slope) / (h + next_h)
    rate = np.where(rate * slope <= 0, 0.0, rate)
    return np.where((slope * next_slope <= 0) & (np.abs(rate) > 3 * np.abs(slope)), 3 * slope, rate)
