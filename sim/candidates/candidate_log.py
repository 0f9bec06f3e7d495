"""Log of moments, and its evaluation for every vehicle."""

import math

import numpy as np

from sim.arrays import Bools, Floats, Ints
from sim.candidates.candidates import Candidates
from sim.candidates.line_of_sight import count_blocked, count_near
from sim.candidates.moment import Body, Moment
from sim.modes import ModeLimits

TURNS_FROM = math.radians(5.0)
"""[rad/s] A vehicle turns from this yaw rate on: a radius of 115 m at 10 m/s."""
NEAR_M = 50.0
"""[m] Default of `grading.range_max_m`, the range within which vehicles are graded."""
_LIMITS = ModeLimits()
_COLUMNS = {"body": np.int32, "moment": np.int32, "speed": np.float32, "yaw": np.float32}
_COUNTS = {"neighbours": np.int16, "near": np.int16, "blocked": np.int16}


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
        self._rows: dict[str, list[Ints | Floats]] = {name: [] for name in _COLUMNS | _COUNTS}

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
        for name, kind in (_COLUMNS | _COUNTS).items():
            self._rows[name].append(values[name].astype(kind))
        self._times.append(moment.time)

    def candidates(self) -> Candidates:
        """Return the vehicles of all moments so far."""
        column = {name: _joined(rows, kind) for (name, kind), rows in zip(
            (_COLUMNS | _COUNTS).items(), self._rows.values(), strict=True)}  # fmt: skip
        order = np.argsort(column["body"], kind="stable")
        column = {name: values[order] for name, values in column.items()}
        body, count = column["body"], len(self._bodies)
        time = np.array(self._times)[column["moment"]] if len(body) else np.empty(0)
        step = (np.diff(time) * (np.diff(body) == 0)).clip(0.0)  # 0 between two vehicles
        mean_speed = 0.5 * (column["speed"][1:] + column["speed"][:-1])
        turn = np.abs(np.diff(column["yaw"]) + math.pi) % math.tau
        turns = (np.abs(turn - math.pi) > TURNS_FROM * step) & (step > 0) & (mean_speed > _LIMITS.moves_from_mps)
        samples, near = np.bincount(body, minlength=count), np.bincount(body, column["near"], count)
        first = np.cumsum(samples) - samples
        driving = np.bincount(body[1:], step, count)

        def share(part: Floats, whole: Floats) -> Floats:
            return part / np.where(whole > 0, whole, 1.0)

        return Candidates(
            bodies=self._bodies,
            enters_s=time[first] if count else np.empty(0),
            stay_s=driving,
            leaves=column["moment"][first + samples - 1] < len(self._times) - 1 if count else np.empty(0, dtype=bool),
            distance_m=np.bincount(body[1:], step * mean_speed, count),
            neighbours=share(np.bincount(body, column["neighbours"], count), samples),
            near=share(near, samples),
            turns=share(np.bincount(body[1:], step * turns, count), driving),
            stops=np.bincount(body[1:][_stops(body, column["speed"])], minlength=count),
            occlusion=share(np.bincount(body, column["blocked"], count), near),
            first=first,
            time=time,
            near_at=column["near"].astype(np.int64),
            speed_at=column["speed"].astype(np.float64),
        )


def _joined(rows: list[Ints | Floats], kind: type) -> Ints | Floats:
    return np.concatenate(rows) if rows else np.empty(0, dtype=kind)


def _stops(body: Ints, speed: Floats) -> Bools:
    """Return True (S - 1,) for the second of two samples if the vehicle comes to a stop in it.

    The limits are those of the true motion modes: it stands from below 0.3 m/s until it reaches 0.5 m/s. A vehicle that
    stands at its first sample has not stopped there.
    """
    state = np.where(speed < _LIMITS.stands_below_mps, 0, np.where(speed >= _LIMITS.moves_from_mps, 1, -1))
    new = np.append(True, np.diff(body) != 0)[: len(body)]
    known = np.flatnonzero((state >= 0) | new)  # between the limits, the last state holds
    held = state[known[np.cumsum((state >= 0) | new) - 1]] if len(body) else state
    return np.asarray((held[1:] == 0) & (held[:-1] == 1) & ~new[1:])
