"""Traffic by replay of recorded trajectories, from the road or from a simulator."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from luxloop import elementwise
from luxloop.arrays import Floats, Ints
from luxloop.sim.frame_builder import FrameBuilder
from luxloop.sim.kinematics import RawFrame, origin_near, wrap_angle
from luxloop.sim.obstacles import obstacles
from luxloop.sim.physical.layer import PhysicalTruth
from luxloop.sim.replay.recording import Recording
from luxloop.sim.replay.recording_checks import contradictions, reversing
from luxloop.sim.replay.recording_files import read_recording
from luxloop.sim.replay.replay_config import ReplayTraffic
from luxloop.sim.replay.trajectories import ROUNDING, Trajectories
from luxloop.sim.roster import Member, Roster
from luxloop.sim.source import EgoCommand, SimulatorFailedError, TrafficEndedError, TrafficInputError
from luxloop.sim.world import Obstacles, WorldFrame

MARGIN = 30.0
"""[m] Margin beyond the delivery radius, so that bodies are in steady motion when they enter it."""
IDS_SHOWN = 8
"""Maximum number of ids in an error message."""


class ReplaySource:
    """Source that plays a recording.

    Parameters
    ----------
    config
        Recording to play.
    folder
        Folder of the scenario file.
    range_m
        Delivery radius around the ego [m].
    """

    def __init__(self, config: ReplayTraffic, folder: Path, range_m: float):
        self.dt = config.dt_s
        self.origin = np.zeros(2)
        self.warnings: tuple[str, ...] = ()
        self.ego_name = config.ego
        self._config = config
        self._folder = folder
        self._range = range_m
        self._recording: Recording | None = None
        self._layer: PhysicalTruth | None = None

    def reset(self, seed: int) -> Obstacles:
        """Read the recording once, and go to its beginning. See `TrafficSource.reset`."""
        try:
            if self._recording is None:
                self._recording = read_recording(self._folder / self._config.file, self._config.types)
                self._trajectories = Trajectories.of(self._recording, self._config.gap_s)
                # Bodies that roll behind their fronts cannot reverse: if one of them does, all are only smoothed.
                self._rolling = not reversing(self._recording, self._trajectories).any()
                found = contradictions(self._recording, self._trajectories)
                self.warnings = tuple(f"{self._config.file}: {warning}" for warning in found)
            self._ego, self._begin = self._beginning(self._recording)
        except TrafficInputError as error:
            raise TrafficInputError(f"{self._config.file}: {error}") from error
        self._first = np.ceil((self._trajectories.begin - self._begin - ROUNDING) / self.dt)
        self._last = np.floor((self._trajectories.end - self._begin + ROUNDING) / self.dt)
        start, _ = self._trajectories.at(np.array([self._ego]), self._begin)
        self.origin = origin_near(start[0, :2])
        self._roster = Roster(seed)
        self._layer = PhysicalTruth(self.dt, self._config.physical, rolling=self._rolling)
        config = self._config
        self._frame_builder = FrameBuilder(self.dt, self._range, config.modes, suspension=config.suspension)
        self._next = 0
        street = [prism for obstacle in self._config.obstacle for prism in obstacle.prisms()]
        street += self._recording.street
        return obstacles([replace(prism, corners=prism.corners - self.origin) for prism in street])

    def step(self) -> WorldFrame:
        """Return the next frame. See `TrafficSource.step`."""
        if (layer := self._layer) is None:
            raise SimulatorFailedError("the recording is not running: call reset before step")
        if (settled := layer.next(lambda: self._advance(layer))) is None:
            raise TrafficEndedError(
                f'{self._config.file}: the samples of ego "{self._config.ego}" end at '
                f"{self._trajectories.end[self._ego]:.2f} s of the recording"
            )
        return self._frame_builder.frame(*settled)

    def apply(self, command: EgoCommand) -> None:
        """Reject the command, since the motion is recorded. See `TrafficSource.apply`."""
        raise TrafficInputError(f'a replay cannot be commanded and accepts no {command}; use kind = "sumo"')

    def close(self) -> None:
        """Stop the replay."""
        self._layer = None

    def _beginning(self, recording: Recording) -> tuple[int, float]:
        """Return the ego's trajectory to play, and the time [s] of frame 0."""
        names = [user.name for user in recording.users]
        if self._config.ego not in names:
            shown = ", ".join(f'"{name}"' for name in names[:IDS_SHOWN])
            raise TrafficInputError(
                f'ego = "{self._config.ego}" is not among its {len(names)} ids; name one of them: {shown}'
                f"{', ...' if len(names) > IDS_SHOWN else ''}"
            )
        rows = np.flatnonzero(self._trajectories.user == names.index(self._config.ego))
        begin, end = self._trajectories.begin[rows], self._trajectories.end[rows]
        start = float(begin[0]) if self._config.begin_s is None else self._config.begin_s
        # a trajectory of one sample has no motion
        usable = np.flatnonzero((begin <= start + ROUNDING) & (start < end - ROUNDING))
        if not len(usable):
            spans = ", ".join(f"{a:g} to {b:g} s" for a, b in list(zip(begin, end, strict=True))[:IDS_SHOWN])
            raise TrafficInputError(
                f'ego "{self._config.ego}" has no motion at {start:g} s, only {spans}; choose another begin_s, '
                f"or raise gap_s = {self._config.gap_s:g} if its samples are further apart"
            )
        return int(rows[usable[0]]), start

    def _advance(self, layer: PhysicalTruth) -> None:
        """Push the next raw frame, or end the run after the ego's last."""
        if self._next > self._last[self._ego]:
            layer.end()
            return
        trajectory, pose, speed = self._near_ego()
        members = [self._member(number) for number in trajectory.tolist()]
        order = np.argsort([member.id for member in members])
        layer.push(RawFrame([members[row] for row in order], pose[order], speed[order]))
        self._next += 1

    def _near_ego(self) -> tuple[Ints, Floats, Floats]:
        """Return the trajectories (N,) near the ego, the ego first, with poses (N, 3) and speeds (N,) [m/s]."""
        rows = np.flatnonzero((self._first <= self._next) & (self._next <= self._last))
        rows = np.concatenate([[self._ego], rows[rows != self._ego]])
        pose, rate = self._trajectories.at(rows, self._begin + self._next * self.dt)
        near = elementwise.hypot(*(pose[:, :2] - pose[0, :2]).T) <= self._range + MARGIN
        rows, pose, rate = rows[near], pose[near], rate[near]
        pose[:, :2] -= self.origin
        pose[:, 2] = wrap_angle(pose[:, 2])
        return rows, pose, rate[:, 0] * elementwise.cos(pose[:, 2]) + rate[:, 1] * elementwise.sin(pose[:, 2])

    def _member(self, trajectory: int) -> Member:
        if member := self._roster.find(trajectory):
            return member
        assert self._recording is not None
        number = int(self._trajectories.user[trajectory])
        user = self._recording.users[number]
        earlier = trajectory - int(np.searchsorted(self._trajectories.user, number))
        name = f"{user.name}#{earlier + 1}" if earlier else user.name
        return self._roster.add(trajectory, user.kind, user.size, name, user.reflectivity)
