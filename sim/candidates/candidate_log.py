"""Log of moments, and its evaluation for every vehicle, with the lines of sight between vehicles, seen from above."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy

from luxloop import elementwise
from luxloop.arrays import Bools, Floats, Ints
from luxloop.sim.candidates.candidates import Body, Candidates, Moment
from luxloop.sim.kinematics import wrap_angle
from luxloop.sim.modes import ModeLimits

CHUNK = 400_000
"""Triples of ego, neighbour and blocker that are tested at a time; it bounds the memory."""


def count_near(place: Floats, counted: Bools, range_m: float) -> Ints:
    """Return the number (N,) of other counted bodies within a range.

    Parameters
    ----------
    place
        (N, 2) box centres [m].
    counted
        (N,) bodies that count.
    range_m
        Range [m], inclusive.
    """
    if not counted.any():
        return np.zeros(len(place), dtype=np.int64)
    found = scipy.spatial.cKDTree(place[counted]).query_ball_point(place, range_m, return_length=True)
    return np.asarray(found, dtype=np.int64) - counted


def count_blocked(pose: Floats, size: Floats, counted: Bools, range_m: float) -> Ints:
    """Return the number (N,) of counted bodies within a range whose line of sight is blocked.

    The line connects the box centres. It is blocked if the box of a third body intersects it. Heights are ignored.

    Parameters
    ----------
    pose
        (N, 3) box centre x [m], y [m], yaw [rad].
    size
        (N, 2) length, width [m].
    counted
        (N,) bodies that count as neighbours; all bodies block.
    range_m
        Range [m], inclusive.
    """
    blocked = np.zeros(len(pose), dtype=np.int64)
    pairs = np.empty((0, 2), int)
    if len(pose):
        pairs = scipy.spatial.cKDTree(pose[:, :2]).query_pairs(range_m, output_type="ndarray")
    if not len(pairs):
        return blocked
    pairs = np.concatenate([pairs, pairs[:, ::-1]])
    pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
    x, y = (pose[pairs[:, 1], :2] - pose[pairs[:, 0], :2]).T
    distance = np.maximum(elementwise.hypot(x, y), 1e-9)
    radius = 0.5 * elementwise.hypot(*size.T)[pairs[:, 1]]
    count = np.bincount(pairs[:, 0], minlength=len(pose))
    first = np.cumsum(count) - count
    for line in _chunks(np.flatnonzero(counted[pairs[:, 1]]), count[pairs[:, 0]]):
        ego = pairs[line, 0]
        target = np.repeat(line, count[ego])
        start = np.repeat(np.cumsum(count[ego]) - count[ego] - first[ego], count[ego])
        blocker = np.arange(len(target)) - start  # the pairs of the same ego, for each of its lines
        # a circle around the box excludes most of them
        ahead = (x[target] * x[blocker] + y[target] * y[blocker]) / distance[target]
        aside = np.abs(x[target] * y[blocker] - y[target] * x[blocker]) / distance[target]
        near = (aside <= radius[blocker]) & (ahead > -radius[blocker]) & (ahead < distance[target] + radius[blocker])
        near &= target != blocker
        target, blocker = target[near], blocker[near]
        box = pairs[blocker, 1]
        hit = _intersects(np.column_stack([x, y])[target], np.column_stack([x, y])[blocker], pose[box, 2], size[box])
        hidden = np.unique(target[hit])
        blocked += np.bincount(pairs[hidden, 0], minlength=len(pose))
    return blocked


def _chunks(rows: Ints, cost: Ints) -> Iterator[Ints]:
    """Yield parts of the rows of pairs (P,) whose costs sum up to about `CHUNK`."""
    if len(rows):
        part = np.cumsum(cost[rows]) // CHUNK
        yield from np.split(rows, np.flatnonzero(np.diff(part)) + 1)


def _intersects(end: Floats, centre: Floats, yaw: Floats, size: Floats) -> Bools:
    """Return True (M,) for segments from the origin that intersect a box, by its slabs (Kay and Kajiya, SIGGRAPH 1986).

    Parameters
    ----------
    end, centre
        (M, 2) ends of the segments and centres of the boxes, relative to the segments' beginnings [m].
    yaw, size
        (M,) [rad] and (M, 2) [m] of the boxes.
    """
    enter, leave = np.zeros(len(end)), np.ones(len(end))
    cos, sin = elementwise.cos(yaw), elementwise.sin(yaw)
    for axis, (x, y) in enumerate(((cos, sin), (-sin, cos))):
        origin = -(centre[:, 0] * x + centre[:, 1] * y)
        direction = end[:, 0] * x + end[:, 1] * y
        direction = np.where(np.abs(direction) < 1e-12, 1e-12, direction)
        bounds = (np.array([[-0.5], [0.5]]) * size[:, axis] - origin) / direction
        enter, leave = np.maximum(enter, bounds.min(axis=0)), np.minimum(leave, bounds.max(axis=0))
    return np.asarray(enter <= leave)


TURNS_FROM = math.radians(5.0)
"""[rad/s] A vehicle turns from this yaw rate on: a radius of 115 m at 10 m/s."""
NEAR_M = 50.0
"""[m] Default of `grading.range_max_m`, the range within which vehicles are graded."""
_LIMITS = ModeLimits()
_TYPES = {
    "body": np.int32, "moment": np.int32, "speed": np.float32, "yaw": np.float32,
    "neighbours": np.int16, "near": np.int16, "blocked": np.int16,
}  # fmt: skip
"""Columns of samples with their types, which bound the memory."""
Column = npt.NDArray[Any]


class CandidateLog:
    """Log of the vehicles of some traffic at regular moments.

    Parameters
    ----------
    range_m
        Sensor range [m].
    near_m
        Range [m] within which vehicles are graded; lines of sight are tested within it.
    """

    def __init__(self, range_m: float, near_m: float = NEAR_M):
        self._range, self._near = range_m, near_m
        self._bodies: list[Body] = []
        self._size = np.empty((0, 2))
        self._graded = np.empty(0, dtype=bool)
        self._times: list[float] = []
        self._rows: dict[str, list[Column]] = {name: [] for name in _TYPES}

    def add(self, moment: Moment) -> None:
        """Add the next moment."""
        if moment.new:
            self._bodies += moment.new
            self._size = np.concatenate([self._size, [body.size for body in moment.new]])
            self._graded = np.append(self._graded, [body.graded for body in moment.new])
        body, pose = moment.body, moment.pose
        graded, size = self._graded[body], self._size[body]
        values = {
            "body": body,
            "moment": np.full(len(body), len(self._times)),
            "speed": moment.speed,
            "yaw": pose[:, 2],
            "neighbours": count_near(pose[:, :2], graded, self._range),
            "near": count_near(pose[:, :2], graded, self._near),
            "blocked": count_blocked(pose, size, graded, self._near),
        }
        for name, kind in _TYPES.items():
            self._rows[name].append(values[name].astype(kind))
        self._times.append(moment.time)

    def candidates(self) -> Candidates:
        """Return the vehicles of all moments so far."""
        samples = {name: np.concatenate(rows or [np.empty(0, _TYPES[name])]) for name, rows in self._rows.items()}
        order = np.argsort(samples["body"], kind="stable")
        return evaluate(self._bodies, np.array(self._times), {name: rows[order] for name, rows in samples.items()})


def evaluate(bodies: list[Body], moments: Floats, samples: dict[str, Column]) -> Candidates:
    """Return the figures of vehicles.

    Parameters
    ----------
    bodies
        The N vehicles.
    moments
        Times of all moments [s].
    samples
        Columns (S,) of `CandidateLog`, ordered by vehicle and then by time.
    """
    body, speed, number = samples["body"], samples["speed"].astype(np.float64), len(bodies)
    time = moments[samples["moment"]] if len(body) else np.empty(0)
    count = np.bincount(body, minlength=number)
    first = np.cumsum(count) - count
    step = (np.diff(time) * (np.diff(body) == 0)).clip(0.0)  # 0 between two vehicles
    mean_speed = 0.5 * (speed[1:] + speed[:-1])
    turn = np.abs(wrap_angle(np.diff(samples["yaw"])))
    turns = (turn > TURNS_FROM * step) & (step > 0) & (mean_speed > _LIMITS.moves_from_mps)

    def total(values: Column) -> Floats:
        return np.bincount(body[len(body) - len(values) :], values, number).astype(np.float64)

    stay = total(step)
    return Candidates(
        bodies=bodies,
        enters_s=time[first] if number else np.empty(0),
        stay_s=stay,
        leaves=samples["moment"][first + count - 1] < len(moments) - 1 if number else np.empty(0, dtype=bool),
        distance_m=total(step * mean_speed),
        neighbours=total(samples["neighbours"]) / count,
        near=total(samples["near"]) / count,
        turns=_share(total(step * turns), stay),
        stops=total(_stops(body, speed)).astype(np.int64),
        occlusion=_share(total(samples["blocked"]), total(samples["near"])),
        first=first,
        time=time,
        near_at=samples["near"].astype(np.int64),
        speed_at=speed,
    )


def _share(part: Floats, whole: Floats) -> Floats:
    return np.asarray(part / np.where(whole > 0, whole, 1.0), dtype=np.float64)


def _stops(body: Column, speed: Floats) -> Bools:
    """Return True (S - 1,) for the second of two samples if the vehicle comes to a stop in it.

    The limits are those of the true motion modes: it stands from below 0.3 m/s until it reaches 0.5 m/s. A vehicle that
    stands at its first sample has not stopped there.
    """
    if not len(body):
        return np.empty(0, dtype=bool)
    state = np.where(speed < _LIMITS.stands_below_mps, 0, np.where(speed >= _LIMITS.moves_from_mps, 1, -1))
    new = np.append(True, np.diff(body) != 0)
    decided = (state >= 0) | new
    held = state[np.flatnonzero(decided)[np.cumsum(decided) - 1]]  # between the limits, the last state holds
    return np.asarray((held[1:] == 0) & (held[:-1] == 1) & ~new[1:])
