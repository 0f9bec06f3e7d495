"""Traffic by replay: trajectories that were recorded elsewhere, on the road or in a simulator."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from sim.arrays import Floats, Ints
from sim.frame_builder import FrameBuilder
from sim.kinematics import RawFrame, wrap_angle
from sim.obstacles import obstacles
from sim.origin import origin_near
from sim.physical.layer import PhysicalTruth
from sim.replay.recording import Recording
from sim.replay.recording_files import read_recording
from sim.replay.replay_config import ReplayTraffic
from sim.replay.trajectories import ROUNDING, Trajectories
from sim.roster import Member, Roster
from sim.source import EgoCommand, SimulatorFailedError, TrafficEndedError, TrafficInputError
from sim.world import Obstacles, WorldFrame

MARGIN = 30.0
"""[m] Beyond the delivery radius: bodies that are this far are followed already, so that they come in rolling."""
TOLD = 8
"""Ids that a complaint names."""


class ReplaySource:
    """A recording, played.

    Parameters
    ----------
    config
        What to play.
    folder
        Folder of the scenario file.
    range_m
        Delivery radius around the ego [m].
    """

    def __init__(self, config: ReplayTraffic, folder: Path, range_m: float):
        self.dt = config.dt_s
        self.origin = np.zeros(2)
        self._config = config
        self._folder = folder
        self._range = range_m
        self._recording: Recording | None = None
        self._layer: PhysicalTruth | None = None

    def reset(self, seed: int) -> Obstacles:
        """Read the recording, once, and go to its beginning. See `TrafficSource.reset`."""
        try:
            if self._recording is None:
                self._recording = read_recording(self._folder / self._config.file, self._config.types)
                self._lives = Trajectories.of(self._recording, self._config.gap_s)
            self._ego, self._begin = self._beginning(self._recording)
        except TrafficInputError as error:
            raise TrafficInputError(f"{self._config.file}: {error}") from error
        self._first = np.ceil((self._lives.begin - self._begin - ROUNDING) / self.dt)
        self._last = np.floor((self._lives.end - self._begin + ROUNDING) / self.dt)
        start, _ = self._lives.at(np.array([self._ego]), self._begin)
        self.origin = origin_near(start[0, :2])
        self._cast = Roster(seed)
        self._layer = PhysicalTruth(self.dt, self._config.physical, rolling=True)
        self._delivery = FrameBuilder(self.dt, self._range, self._config.modes)
        self._next = 0
        street = [prism for obstacle in self._config.obstacle for prism in obstacle.prisms()]
        street += self._recording.street
        return obstacles([replace(prism, corners=prism.corners - self.origin) for prism in street])

    def step(self) -> WorldFrame:
        """Return the next frame. See `TrafficSource.step`."""
        if (layer := self._layer) is None:
            raise SimulatorFailedError("the recording is not played: reset comes before step")
        if (settled := layer.next(lambda: self._advance(layer))) is None:
            raise TrafficEndedError(
                f'{self._config.file}: the samples of ego "{self._config.ego}" end at '
                f"{self._lives.end[self._ego]:.2f} s of the recording"
            )
        return self._delivery.frame(*settled)

    def apply(self, command: EgoCommand) -> None:
        """Refuse: what has happened has happened. See `TrafficSource.apply`."""
        raise TrafficInputError(f'a replay cannot be commanded, and takes no {command}; use kind = "sumo"')

    def close(self) -> None:
        """Stop playing."""
        self._layer = None

    def _beginning(self, recording: Recording) -> tuple[int, float]:
        """Return the ego's life that is played, and the time [s] of frame 0."""
        names = [user.name for user in recording.users]
        if self._config.ego not in names:
            told = ", ".join(f'"{name}"' for name in names[:TOLD])
            raise TrafficInputError(
                f'ego = "{self._config.ego}" is not among its {len(names)} ids; name one of them: {told}'
                f"{', ...' if len(names) > TOLD else ''}"
            )
        lives = np.flatnonzero(self._lives.user == names.index(self._config.ego))
        begin, end = self._lives.begin[lives], self._lives.end[lives]
        start = float(begin[0]) if self._config.begin_s is None else self._config.begin_s
        # a life of one sample has no motion
        playable = np.flatnonzero((begin <= start + ROUNDING) & (start < end - ROUNDING))
        if not len(playable):
            spans = ", ".join(f"{a:g} to {b:g} s" for a, b in list(zip(begin, end, strict=True))[:TOLD])
            raise TrafficInputError(
                f'ego "{self._config.ego}" has no motion at {start:g} s, only {spans}; choose another begin_s, '
                f"or raise gap_s = {self._config.gap_s:g} if its samples are further apart"
            )
        return int(lives[playable[0]]), start

    def _advance(self, layer: PhysicalTruth) -> None:
        """Push the next raw frame, or say that there is none."""
        if self._next > self._last[self._ego]:
            layer.end()
            return
        life, pose, speed = self._present()
        members = [self._member(number) for number in life.tolist()]
        order = np.argsort([member.id for member in members])
        layer.push(RawFrame([members[row] for row in order], pose[order], speed[order]))
        self._next += 1

    def _present(self) -> tuple[Ints, Floats, Floats]:
        """Return the lives (N,) near the ego in the next frame, the ego first, poses (N, 3) and speeds (N,) [m/s]."""
        there = np.flatnonzero((self._first <= self._next) & (self._next <= self._last))
        there = np.concatenate([[self._ego], there[there != self._ego]])
        pose, rate = self._lives.at(there, self._begin + self._next * self.dt)
        near = np.hypot(*(pose[:, :2] - pose[0, :2]).T) <= self._range + MARGIN
        there, pose, rate = there[near], pose[near], rate[near]
        pose[:, :2] -= self.origin
        pose[:, 2] = wrap_angle(pose[:, 2])
        return there, pose, rate[:, 0] * np.cos(pose[:, 2]) + rate[:, 1] * np.sin(pose[:, 2])

    def _member(self, life: int) -> Member:
        if member := self._cast.find(life):
            return member
        assert self._recording is not None
        number = int(self._lives.user[life])
        user = self._recording.users[number]
        earlier = life - int(np.searchsorted(self._lives.user, number))
        name = f"{user.name}#{earlier + 1}" if earlier else user.name
        return self._cast.enter(life, user.kind, user.size, name, user.reflectivity)
