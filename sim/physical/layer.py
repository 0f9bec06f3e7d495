"""Physical truth layer: convert raw simulator frames to feasible motions, with a delay of some frames."""

from collections import deque
from collections.abc import Callable

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats, Ints
from luxloop.sim.kinematics import Kinematics, RawFrame
from luxloop.sim.physical.body_tables import BodyTables, has_sections
from luxloop.sim.physical.kernels.frame_input import store_frame
from luxloop.sim.physical.kernels.frame_motion import frame_motions
from luxloop.sim.physical.lane_change import SpreadLaneChange
from luxloop.sim.physical.limits import BEHIND_S, SIDESTEP
from luxloop.sim.physical.physical_config import PhysicalConfig
from luxloop.sim.physical.section_chain import SectionChain
from luxloop.sim.physical.spline import acceleration_weights, smoothing_weights, velocity_weights
from luxloop.sim.roster import Member
from luxloop.sim.world import JOINTS, Kind


class PhysicalTruth:
    """Converter of raw frames to motions, in order, each as soon as the look-ahead allows.

    Parameters
    ----------
    dt
        Time between frames [s].
    config
        Smoothing parameters.
    rolling
        If true, the front of each body follows the smoothed path and the rear axle rolls without slip. If false, the
        raw poses already roll or slip realistically: they are only smoothed, and jumps across lanes remain.
    """

    def __init__(self, dt: float, config: PhysicalConfig, *, rolling: bool):
        self._dt = dt
        self._rolling = rolling
        self._ahead = round(config.lookahead_s / dt)
        half = max(round(config.smoothing_s / dt), 1)
        smoothing = smoothing_weights(half) if config.smoothing_s else np.array([0.0, 1.0, 0.0])
        self._weights = np.stack([smoothing, velocity_weights(half, dt), acceleration_weights(half, dt)])
        self._window = half + max(half, self._ahead) + 2
        self._tables = BodyTables(self._window, trail=round((BEHIND_S + 1.0) / dt))
        # a lane change is centred on the jump, but cannot start before frames that are already final
        self._change_fraction = dt / config.lane_change_s
        self._lead_frames = int(np.clip(self._ahead - half, 0, round(0.5 * config.lane_change_s / dt)))
        self._lane_changes: list[SpreadLaneChange] = []
        self._chains: dict[tuple[int, int], SectionChain] = {}
        """Trams and trains of the last final frame, by id and stretch."""
        self._waiting: deque[tuple[RawFrame, Ints]] = deque()
        self._pushed = 0
        self._ended = False

    def push(self, raw: RawFrame) -> None:
        """Append the next raw frame. Call `pop` until it returns None before the next `push`."""
        tables, frame = self._tables, self._pushed
        body = tables.rows(raw.members, frame)
        jump = store_frame(
            frame, body, raw.pose_world, raw.speed, tables.history, tables.dimensions, self._rolling, self._dt
        )
        self._continue_lane_changes(frame)
        for n in np.flatnonzero(jump):
            if raw.members[n].kind is not Kind.PEDESTRIAN or abs(jump[n]) > SIDESTEP:
                self._begin_lane_change(frame, int(body[n]), float(jump[n]))
        self._waiting.append((raw, body))
        self._pushed += 1
        if frame % self._window == 0:
            tables.release(frame - self._window)

    def end(self) -> None:
        """Mark the end of the raw frames; the frames in the queue can still be popped."""
        self._ended = True

    def pop(self) -> tuple[list[Member], Kinematics] | None:
        """Return members and motion of the next final frame, or None if there is none yet."""
        if not self._waiting or (len(self._waiting) <= self._ahead and not self._ended):
            return None
        frame, tables = self._pushed - len(self._waiting), self._tables
        raw, body = self._waiting.popleft()
        members = raw.members
        motion = frame_motions(
            frame,
            self._pushed,
            body,
            tables.history,
            self._weights,
            tables.states,
            tables.dimensions,
            self._rolling,
            self._dt,
        )
        further = self._follow_rails(members, motion, tables.history.raw[body, frame % self._window, 2])
        return members, Kinematics(
            pose_world=motion[:, :3],
            velocity_world=motion[:, 3:5],
            acceleration_world=motion[:, 5:7],
            yaw_rate=motion[:, 7],
            articulation=motion[:, 8],
            changes_lane=tables.history.changes_lane[body, frame % tables.history.frame.shape[1]],
            deviation=motion[:, 9:],
            road=raw.road,
            further_articulation=further,
            collisions=raw.collisions,
        )

    def next(self, advance: Callable[[], None]) -> tuple[list[Member], Kinematics] | None:
        """Return members and motion of the next final frame, or None at the end.

        `advance` steps the simulator by one frame: it calls `push`, or `end` if there are no further frames.
        """
        while (settled := self.pop()) is None and not self._ended:
            advance()
        return settled

    def _follow_rails(self, members: list[Member], motion: Floats, yaw: Floats) -> Floats:
        """Replace the motion of fronts of trams and trains by that of their boxes; return their further angles.

        `yaw` (N,) [rad] are those of the simulator.
        """
        before, self._chains = self._chains, {}
        further = np.zeros((len(members), JOINTS - 1))
        for row in [row for row, member in enumerate(members) if has_sections(member)] if self._rolling else []:
            member = members[row]
            key = member.id, member.stretch
            chain = before.get(key) or SectionChain(member, motion[row, :7], float(yaw[row]))
            motion[row, :8], angles = chain.follow(motion[row, :8])
            motion[row, 8], further[row] = angles[0], angles[1:]
            self._chains[key] = chain
        return further

    def _begin_lane_change(self, frame: int, body: int, offset: float) -> None:
        """Start to spread a jump at a frame, including some frames before it."""
        change, known = SpreadLaneChange(body, frame, offset), self._tables.history.frame[body]
        for at in range(max(frame - self._lead_frames, 0), frame + 1):
            if known[at % len(known)] == at:
                change = self._shift(change, at)
        self._lane_changes.append(change)

    def _continue_lane_changes(self, frame: int) -> None:
        """Shift the bodies that change lanes at a new frame."""
        known = self._tables.history.frame
        row = frame % known.shape[1]
        self._lane_changes = [
            self._shift(change, frame)
            for change in self._lane_changes
            if known[change.body, row] == frame and change.progress < 1
        ]

    def _shift(self, change: SpreadLaneChange, frame: int) -> SpreadLaneChange:
        history = self._tables.history
        row = frame % history.frame.shape[1]
        change = change.advanced(history.speed[change.body, row], self._change_fraction)
        course = history.path[change.body, row, 2]
        history.path[change.body, row, :2] += change.shift(frame) * np.array(
            [-elementary.sin(course), elementary.cos(course)]
        )
        history.changes_lane[change.body, row] = True
        return change
