"""The physical truth layer: a simulator's frames in, motions that bodies can make out, some frames later."""

from collections import deque
from collections.abc import Callable

import numpy as np

from sim.arrays import Ints
from sim.kinematics import Kinematics, RawFrame
from sim.physical.body_tables import Tables
from sim.physical.kernels.frame_motion import settle
from sim.physical.kernels.poses_in import note
from sim.physical.lane_change import SpreadLaneChange
from sim.physical.limits import BEHIND_S
from sim.physical.physical_config import PhysicalConfig
from sim.physical.spline import acceleration_weights, smoothing_weights, velocity_weights
from sim.roster import Member


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
        half = max(round(config.smoothing_s / dt), 1)
        smoothing = smoothing_weights(half) if config.smoothing_s else np.array([0.0, 1.0, 0.0])
        self._weights = np.stack([smoothing, velocity_weights(half, dt), acceleration_weights(half, dt)])
        self._window = half + max(half, self._ahead) + 2
        self._tables = Tables(self._window, trail=round((BEHIND_S + 1.0) / dt))
        # a change begins so that the jump falls into its middle, but not before frames that are settled already
        self._change_fraction = dt / config.lane_change_s
        self._lead_frames = int(np.clip(self._ahead - half, 0, round(0.5 * config.lane_change_s / dt)))
        self._changing: list[SpreadLaneChange] = []
        self._waiting: deque[tuple[list[Member], Ints]] = deque()
        self._pushed = 0
        self._ended = False

    def push(self, raw: RawFrame) -> None:
        """Take in the next raw frame; `pop` until there is none before the next."""
        tables, frame = self._tables, self._pushed
        body = tables.rows(raw.members, frame)
        jump = note(frame, body, raw.pose_world, raw.speed, tables.said, tables.builds, self._rolls, self._dt)
        self._go_on_changing(frame)
        for n in np.flatnonzero(jump):
            self._begin_to_change(frame, int(body[n]), float(jump[n]))
        self._waiting.append((raw.members, body))
        self._pushed += 1
        if frame % self._window == 0:
            tables.forget(frame - self._window)

    def end(self) -> None:
        """Say that there will be no further raw frames; those that wait still come out."""
        self._ended = True

    def pop(self) -> tuple[list[Member], Kinematics] | None:
        """Return members and motion of the next settled frame, None if there is none (yet)."""
        if not self._waiting or (len(self._waiting) <= self._ahead and not self._ended):
            return None
        frame, tables = self._pushed - len(self._waiting), self._tables
        members, body = self._waiting.popleft()
        motion = settle(
            frame, self._pushed, body, tables.said, self._weights, tables.led, tables.builds, self._rolls, self._dt
        )
        return members, Kinematics(
            pose_world=motion[:, :3],
            velocity_world=motion[:, 3:5],
            acceleration_world=motion[:, 5:7],
            yaw_rate=motion[:, 7],
            articulation=motion[:, 8],
            changes_lane=tables.said.changes_lane[body, frame % tables.said.frame.shape[1]],
            deviation=motion[:, 9:],
        )

    def next(self, advance: Callable[[], None]) -> tuple[list[Member], Kinematics] | None:
        """Return members and motion of the next settled frame, None at the end.

        `advance` lets the simulator go on by a frame: it pushes that, or says that there are no further ones.
        """
        while (settled := self.pop()) is None and not self._ended:
            advance()
        return settled

    def _begin_to_change(self, frame: int, body: int, offset: float) -> None:
        """Spread a jump at a frame, over some frames before it too."""
        change, known = SpreadLaneChange(body, frame, offset), self._tables.said.frame[body]
        for at in range(max(frame - self._lead_frames, 0), frame + 1):
            if known[at % len(known)] == at:
                change = self._shift(change, at)
        self._changing.append(change)

    def _go_on_changing(self, frame: int) -> None:
        """Shift those who are changing lanes at a new frame."""
        known = self._tables.said.frame
        row = frame % known.shape[1]
        self._changing = [
            self._shift(change, frame)
            for change in self._changing
            if known[change.body, row] == frame and change.progress < 1
        ]

    def _shift(self, change: SpreadLaneChange, frame: int) -> SpreadLaneChange:
        said = self._tables.said
        row = frame % said.frame.shape[1]
        change = change.onward(said.speed[change.body, row], self._change_fraction)
        course = said.path[change.body, row, 2]
        said.path[change.body, row, :2] += change.shift(frame) * np.array([-np.sin(course), np.cos(course)])
        said.changes_lane[change.body, row] = True
        return change
