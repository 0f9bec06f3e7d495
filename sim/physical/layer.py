"""The physical truth layer: a simulator's frames in, motions that bodies can make out, some frames later."""

from collections import deque
from dataclasses import dataclass, fields, replace
from typing import TypeVar

import numpy as np

from sim.articulation import Hitch, hitch
from sim.cast import Member
from sim.kinematics import Kinematics, RawFrame, wrap_angle
from sim.physical.config import PhysicalConfig
from sim.physical.driving import BEHIND_S, drive
from sim.physical.path import Path, Trail
from sim.physical.rolling import YAW_RATE, YAW_RATE_ON_FOOT, Build, Rolling, set_rolling
from sim.physical.trailer import Trailers
from sim.physical.window import Reference, Window
from sim.world import Floats, Ints, Kind

REAR_AXLE = 0.8
"""Where the rear axle is, as a share of the length behind the front bumper: of cars and, roughly, of all others."""
SHORTEST_LEAD = 0.3
"""[m] At least from rear axle to front, for those who walk."""

Record = TypeVar("Record", Rolling, Path, Build)


@dataclass(frozen=True, slots=True, eq=False)
class _Cast:
    """What matters here of N members."""

    id: Ints
    length: Floats
    build: Build
    bends: Ints
    """(T,) rows of those with a trailer."""
    hitch: Hitch
    """Of those."""

    @classmethod
    def of(cls, members: list[Member]) -> "_Cast":
        length = np.array([member.size[0] for member in members])
        bends = np.flatnonzero([member.kind is Kind.TRAILER_TRUCK for member in members])
        coupling = hitch(length[bends])
        lead = np.maximum(REAR_AXLE * length, SHORTEST_LEAD)
        arm = lead - 0.5 * length
        lead[bends], arm[bends] = coupling.drive_axle, 0.0  # a tractor's; the box is the trailer's
        walks = np.array([member.kind is Kind.PEDESTRIAN for member in members])
        build = Build(lead, arm, np.where(walks, YAW_RATE_ON_FOOT, YAW_RATE))
        return cls(np.array([member.id for member in members]), length, build, bends, coupling)


class PhysicalTruth:
    """Turns raw frames into motions, in order, each as soon as the look-ahead allows.

    Parameters
    ----------
    dt
        Time between frames [s].
    config
        How it smooths.
    rolling
        Whether bodies are to be led by their fronts and follow on their rear axles. If not, the raw poses are already
        those of a body that rolls or slips as it should; they are only smoothed, and jumps across lanes stay.
    """

    def __init__(self, dt: float, config: PhysicalConfig, *, rolling: bool):
        self._dt = dt
        self._rolls = rolling
        self._ahead = round(config.lookahead_s / dt)
        self._window = Window(dt, config, leads=rolling)
        self._waiting: deque[RawFrame] = deque()
        self._pushed = 0
        self._ended = False
        self._id = np.empty(0, np.int64)
        self._bodies: Rolling
        self._lag: Floats
        self._trail = Trail(dt, BEHIND_S + 1.0)
        self._trailers = Trailers(dt)

    def push(self, raw: RawFrame) -> None:
        """Take in the next raw frame."""
        cast = _Cast.of(raw.members)
        forward = 0.5 * cast.length[:, None] * self._rolls
        yaw = raw.pose_world[:, 2]
        point = raw.pose_world[:, :2] + forward * np.column_stack([np.cos(yaw), np.sin(yaw)])
        self._window.push(self._pushed, cast.id, np.column_stack([point, yaw]), raw.speed)
        self._waiting.append(raw)
        self._pushed += 1

    def end(self) -> None:
        """Say that there will be no further raw frames; those that wait still come out."""
        self._ended = True

    def pop(self) -> tuple[list[Member], Kinematics] | None:
        """Return members and motion of the next settled frame, None if there is none (yet)."""
        if not self._waiting or (len(self._waiting) <= self._ahead and not self._ended):
            return None
        members = self._waiting[0].members
        cast = _Cast.of(members)
        reference = self._window.reference(self._pushed - len(self._waiting), cast.id, self._pushed)
        self._waiting.popleft()
        return members, self._rolled(cast, reference) if self._rolls else _smoothed(reference)

    def _rolled(self, cast: _Cast, reference: Reference) -> Kinematics:
        """Let bodies follow the reference on their wheels."""
        path = Path(reference.path[:, :2], reference.rate[:, :2], reference.bend[:, :2])
        bodies = self._led(cast, path, reference.raw[:, 2])
        front, _, _ = bodies.at(cast.build.lead)
        place, velocity, acceleration = bodies.at(cast.build.lead - 0.5 * cast.length)
        motion = Kinematics(
            pose_world=np.column_stack([place, wrap_angle(bodies.yaw)]),
            velocity_world=velocity,
            acceleration_world=acceleration,
            yaw_rate=bodies.yaw_rate.copy(),  # a trailer's takes its place, and must not take it in the state
            articulation=np.zeros(len(place)),
            changes_lane=reference.changes_lane,
            deviation=_deviation(front - reference.raw[:, :2], reference.path[:, 2]),
        )
        return self._bent(cast, bodies, motion) if len(cast.bends) else motion

    def _led(self, cast: _Cast, path: Path, yaw: Floats) -> Rolling:
        """Roll those on who were there in the last frame; put the others where they should be."""
        _, stay, before = np.intersect1d(cast.id, self._id, assume_unique=True, return_indices=True)
        come = np.setdiff1d(np.arange(len(cast.id)), stay, assume_unique=True)
        self._trail.add(cast.id, cast.id[come], path)
        bodies, lag = [set_rolling(_rows(path, come), yaw[come], _rows(cast.build, come))], [np.zeros(len(come))]
        if len(stay):
            build = _rows(cast.build, stay)
            rolled = drive(_rows(self._bodies, before), self._lag[before], cast.id[stay], self._trail, build, self._dt)
            bodies.append(rolled[0])
            lag.append(rolled[1])
        order = np.argsort(np.concatenate([come, stay]))
        self._id, self._lag = cast.id, np.concatenate(lag)[order]
        self._bodies = Rolling(
            *(np.concatenate([getattr(part, column.name) for part in bodies])[order] for column in fields(Rolling))
        )
        return self._bodies

    def _bent(self, cast: _Cast, bodies: Rolling, motion: Kinematics) -> Kinematics:
        """Replace the motion of tractors by that of the trailers behind them."""
        rows = cast.bends
        tractor = _rows(bodies, rows)
        trailing = self._trailers.follow(cast.id[rows], tractor, cast.length[rows], cast.hitch)
        place, velocity, acceleration = trailing.centre
        motion.pose_world[rows] = np.column_stack([place, wrap_angle(trailing.yaw)])
        motion.velocity_world[rows] = velocity
        motion.acceleration_world[rows] = acceleration
        motion.yaw_rate[rows] = trailing.yaw_rate
        motion.articulation[rows] = wrap_angle(tractor.yaw - trailing.yaw)
        return motion


def _smoothed(reference: Reference) -> Kinematics:
    """Take the smoothed poses for the motion."""
    return Kinematics(
        pose_world=np.column_stack([reference.path[:, :2], wrap_angle(reference.path[:, 2])]),
        velocity_world=reference.rate[:, :2],
        acceleration_world=reference.bend[:, :2],
        yaw_rate=reference.rate[:, 2],
        articulation=np.zeros(len(reference.path)),
        changes_lane=reference.changes_lane,
        deviation=_deviation(reference.path[:, :2] - reference.raw[:, :2], reference.path[:, 2]),
    )


def _deviation(offset: Floats, course: Floats) -> Floats:
    """Return how much of offsets (N, 2) is ahead and how much to the left of courses (N,)."""
    cos, sin = np.cos(course), np.sin(course)
    return np.column_stack([offset[:, 0] * cos + offset[:, 1] * sin, offset[:, 1] * cos - offset[:, 0] * sin])


def _rows(record: Record, rows: Ints) -> Record:
    return replace(record, **{column.name: getattr(record, column.name)[rows] for column in fields(record)})
