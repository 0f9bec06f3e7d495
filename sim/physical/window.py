"""The simulator's latest frames, and the smooth path that they mean for each body."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sim.kinematics import wrap_angle
from sim.physical.config import PhysicalConfig
from sim.physical.lane_change import LaneChange, courses
from sim.physical.spline import acceleration_weights, smoothing_weights, velocity_weights
from sim.world import Floats, Ints

Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """How N bodies ought to move at one instant: the smoothed path of one point of each."""

    path: Floats
    """(N, 3) x [m], y [m], and the course of a front that leads, or else the body's yaw [rad]."""
    rate: Floats
    """(N, 3) its first derivative [m/s, rad/s]."""
    bend: Floats
    """(N, 3) its second derivative [m/s^2, rad/s^2]."""
    raw: Floats
    """(N, 3) the simulator's own x [m], y [m], yaw [rad]."""
    changes_lane: Bools
    """(N,) a lane jump is being spread."""


class Window:
    """Ring buffer of what the simulator said of each body, by the body's number.

    Parameters
    ----------
    dt
        Time between frames [s].
    config
        Of the layer.
    leads
        Whether the points are fronts that lead bodies, and jumps across lanes are to be spread.
    """

    def __init__(self, dt: float, config: PhysicalConfig, *, leads: bool):
        self._dt = dt
        self._leads = leads
        self._half = max(round(config.smoothing_s / dt), 1)
        smoothing = smoothing_weights(self._half) if config.smoothing_s else np.array([0.0, 1.0, 0.0])
        self._weights = np.stack([smoothing, velocity_weights(self._half, dt), acceleration_weights(self._half, dt)])
        ahead = round(config.lookahead_s / dt)
        self._change_fraction = dt / config.lane_change_s
        # the change begins so that the jump falls into its middle, but not before frames that are smoothed already
        self._lead = int(np.clip(ahead - self._half, 0, round(0.5 * config.lane_change_s / dt)))
        self._length = self._half + max(self._half, ahead) + 2
        self._changing: list[LaneChange] = []
        self._present: Bools = np.zeros((self._length, 0), np.bool_)
        self._shifting: Bools = np.zeros((self._length, 0), np.bool_)
        self._speed: Floats = np.zeros((self._length, 0))
        self._raw: Floats = np.zeros((self._length, 0, 3))
        self._path: Floats = np.zeros((self._length, 0, 3))

    def push(self, frame: int, id: Ints, raw: Floats, speed: Floats) -> None:
        """Take in a raw frame: N numbers, points and yaws (N, 3), speeds (N,) [m/s]."""
        if id[-1] >= self._present.shape[1]:
            self._grow(2 * int(id[-1]) + 64)
        row, before = frame % self._length, (frame - 1) % self._length
        self._present[row] = False
        self._present[row, id] = True
        self._shifting[row] = False
        self._raw[row, id] = self._path[row, id] = raw
        self._speed[row, id] = speed
        if self._leads and frame:
            stayed = id[self._present[before, id]]
            step = self._raw[row, stayed, :2] - self._raw[before, stayed, :2]
            course, jumped, offset = courses(self._path[before, stayed, 2], step, self._dt)
            self._path[row, stayed, 2] = course
            # where somebody new came from is where the first step leads; until then the simulator's angle has to do
            new = stayed[~self._present[before - 1, stayed]] if frame > 1 else stayed
            self._path[before, new, 2] = self._path[row, new, 2]
            self._go_on(frame)
            for jumper, jump in zip(stayed[jumped].tolist(), offset.tolist(), strict=True):
                self._begin(frame, jumper, jump)

    def reference(self, frame: int, id: Ints, pushed: int) -> Reference:
        """Smooth the path around a frame, as far as frames before `pushed` tell; beyond, bodies keep their speed.

        Parameters
        ----------
        frame
            Number of the frame.
        id
            (N,) bodies that are in it.
        pushed
            Number of raw frames so far.
        """
        offset = np.arange(-self._half, self._half + 1)
        row = (frame + offset) % self._length
        there = self._present[row][:, id] & ((frame + offset >= 0) & (frame + offset < pushed))[:, None]
        path = self._path[row][:, id]
        now = path[self._half]
        path[:, :, 2] = now[:, 2] + wrap_angle(path[:, :, 2] - now[:, 2])
        way = self._speed[row][:, id] * self._dt
        halves = slice(self._half, None), slice(self._half, None, -1)
        for sign, half, other in zip((1, -1), halves, halves[::-1], strict=True):
            last = _last(there[half])
            step = _straight(path[half], sign * way[half], last)
            if not self._leads:
                step = _steady(path[half], path[other], there[other], last, step)
            _continue(path[half], last, step)
        smooth, rate, bend = np.einsum("dw,wnc->dnc", self._weights, path - now)
        row_now = frame % self._length
        return Reference(now + smooth, rate, bend, self._raw[row_now, id], self._shifting[row_now, id])

    def _grow(self, size: int) -> None:
        """Make room for bodies with numbers below `size`."""
        room = ((0, 0), (0, size - self._present.shape[1]))
        self._present, self._shifting = np.pad(self._present, room), np.pad(self._shifting, room)
        self._speed = np.pad(self._speed, room)
        self._raw, self._path = (np.pad(poses, (*room, (0, 0))) for poses in (self._raw, self._path))

    def _begin(self, frame: int, id: int, offset: float) -> None:
        """Spread a jump at a frame, the frames before it included."""
        change = LaneChange(id, frame, offset)
        for at in range(frame - self._lead, frame + 1):
            if at >= 0 and self._present[at % self._length, id]:
                change = self._shift(change, at)
        self._changing.append(change)

    def _go_on(self, frame: int) -> None:
        """Shift those who are changing lanes at a new frame."""
        row = frame % self._length
        self._changing = [
            self._shift(change, frame)
            for change in self._changing
            if self._present[row, change.id] and change.progress < 1
        ]

    def _shift(self, change: LaneChange, frame: int) -> LaneChange:
        row = frame % self._length
        change = change.onward(self._speed[row, change.id], self._change_fraction)
        course = self._path[row, change.id, 2]
        self._path[row, change.id, :2] += change.shift(frame) * np.array([-np.sin(course), np.cos(course)])
        self._shifting[row, change.id] = True
        return change


def _last(there: Bools) -> Ints:
    """Return the last row (N,) before the first in which bodies are missing (W, N)."""
    known: Ints = np.logical_and.accumulate(there, axis=0).sum(axis=0)
    return known - 1


def _straight(path: Floats, way: Floats, last: Ints) -> Floats:
    """Return the steps (N, 3) that go straight on from the last known poses of (W, N, 3), by their `way` (W, N) [m]."""
    body = np.arange(path.shape[1])
    course, length = path[last, body, 2], way[last, body]
    return np.column_stack([length * np.cos(course), length * np.sin(course), np.zeros(len(body))])


def _steady(path: Floats, other: Floats, other_there: Bools, last: Ints, straight: Floats) -> Floats:
    """Return the last known steps (N, 3), turn included; from the other side of the window where this one has none."""
    body = np.arange(path.shape[1])
    step = path[last, body] - path[np.maximum(last - 1, 0), body]
    turned_around = np.where(other_there[1, :, None], path[0] - other[1], straight)
    return np.where((last > 0)[:, None], step, turned_around)


def _continue(path: Floats, last: Ints, step: Floats) -> None:
    """Fill in poses (W, N, 3) behind the last known rows (N,) by steps (N, 3)."""
    ahead = np.arange(len(path))[:, None] - last
    missing = ahead > 0
    if missing.any():
        end = path[last, np.arange(len(last))]
        path[missing] = (end + ahead[:, :, None] * step)[missing]
