"""Log of moments, and its evaluation for every vehicle."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from luxloop.arrays import Bools, Floats
from luxloop.sim.candidates.candidates import Candidates
from luxloop.sim.candidates.line_of_sight import count_blocked, count_near
from luxloop.sim.candidates.moment import Body, Moment
from luxloop.sim.kinematics import wrap_angle
from luxloop.sim.modes import ModeLimits

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
