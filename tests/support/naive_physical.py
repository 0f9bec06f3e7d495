"""Naive twin of sim/physical/kernels: numpy operations on all bodies at a time."""

import math
from collections import deque
from dataclasses import dataclass, fields, replace

import numpy as np

from luxloop.sim.articulation import hitch
from luxloop.sim.kinematics import Kinematics, wrap_angle
from luxloop.sim.physical.body_tables import REAR_AXLE, SHORTEST_LEAD
from luxloop.sim.physical.lane_change import SpreadLaneChange
from luxloop.sim.physical.limits import (
    ACCELERATION_MAX,
    AHEAD_S,
    AIM_M,
    AIM_RAD,
    AIM_S,
    BEHIND_S,
    CATCH_UP,
    CATCH_UP_LEAST,
    CATCH_UP_SHARE,
    CORNER,
    CREEP,
    GRIP,
    JERK,
    JUMP_LONGEST,
    JUMP_SPEED,
    LAG_STEP_S,
    LATERAL_ACCELERATION,
    LATERAL_JERK,
    LEAST_STEP,
    SETTLING_S,
    SIDESTEP,
    SLOW,
    STANDING,
    STEERING,
    STEERING_S,
    STEP_S,
    SWING,
    SWING_ABOVE,
    YAW_RATE_ON_FOOT,
    YAW_RATE_ON_WHEELS,
)
from luxloop.sim.physical.spline import acceleration_weights, smoothing_weights, velocity_weights
from luxloop.sim.world import Kind


def courses(before, step, dt):
    """Return courses of bodies, a mask of those that jumped to the next lane, and their jumps."""
    cos, sin = (np.cos(before), np.sin(before))
    across = step[:, 1] * cos - step[:, 0] * sin
    along = step[:, 0] * cos + step[:, 1] * sin
    jumped = (np.abs(across) > JUMP_SPEED * dt + CORNER * np.abs(along)) & (np.abs(across) <= JUMP_LONGEST)
    moved = ~jumped & (np.hypot(*step.T) > LEAST_STEP)
    return (np.where(moved, np.arctan2(step[:, 1], step[:, 0]), before), jumped, across[jumped])


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """Smoothed paths of one point of each of N bodies at one instant."""

    path: object
    rate: object
    bend: object
    raw: object
    changes_lane: object


class Window:
    """Ring buffer of the raw input of each body, by the body's number."""

    def __init__(self, dt, config, *, rolling):
        self._dt = dt
        self._rolling = rolling
        self._half = max(round(config.smoothing_s / dt), 1)
        smoothing = smoothing_weights(self._half) if config.smoothing_s else np.array([0.0, 1.0, 0.0])
        self._weights = np.stack([smoothing, velocity_weights(self._half, dt), acceleration_weights(self._half, dt)])
        ahead = round(config.lookahead_s / dt)
        self._change_fraction = dt / config.lane_change_s
        self._lead = int(np.clip(ahead - self._half, 0, round(0.5 * config.lane_change_s / dt)))
        self._length = self._half + max(self._half, ahead) + 2
        self._lane_changes = []
        self._present = np.zeros((self._length, 0), np.bool_)
        self._shifting = np.zeros((self._length, 0), np.bool_)
        self._speed = np.zeros((self._length, 0))
        self._raw = np.zeros((self._length, 0, 3))
        self._path = np.zeros((self._length, 0, 3))

    def push(self, frame, id, raw, speed, walks):
        """Append a raw frame: N numbers, points and yaws (N, 3), speeds (N,) [m/s], mask of people (N,)."""
        if id[-1] >= self._present.shape[1]:
            self._grow(2 * int(id[-1]) + 64)
        row, before = (frame % self._length, (frame - 1) % self._length)
        self._present[row] = False
        self._present[row, id] = True
        self._shifting[row] = False
        self._raw[row, id] = self._path[row, id] = raw
        self._speed[row, id] = speed
        if self._rolling and frame:
            stayed = id[self._present[before, id]]
            step = self._raw[row, stayed, :2] - self._raw[before, stayed, :2]
            course, jumped, offset = courses(self._path[before, stayed, 2], step, self._dt)
            self._path[row, stayed, 2] = course
            new = stayed[~self._present[before - 1, stayed]] if frame > 1 else stayed
            self._path[before, new, 2] = self._path[row, new, 2]
            self._continue_lane_changes(frame)
            for jumper, jump in zip(stayed[jumped].tolist(), offset.tolist(), strict=True):
                if not (jumper in id[walks] and abs(jump) <= SIDESTEP):
                    self._begin_lane_change(frame, jumper, jump)

    def reference(self, frame, id, pushed):
        """Smooth the path around a frame; beyond the `pushed` frames, bodies are extrapolated."""
        offset = np.arange(-self._half, self._half + 1)
        row = (frame + offset) % self._length
        present = self._present[row][:, id] & ((frame + offset >= 0) & (frame + offset < pushed))[:, None]
        path = self._path[row][:, id]
        now = path[self._half]
        path[:, :, 2] = now[:, 2] + wrap_angle(path[:, :, 2] - now[:, 2])
        distance = self._speed[row][:, id] * self._dt
        halves = (slice(self._half, None), slice(self._half, None, -1))
        for sign, half, other in zip((1, -1), halves, halves[::-1], strict=True):
            last = _last(present[half])
            step = _straight(path[half], sign * distance[half], last)
            if not self._rolling:
                step = _steady(path[half], path[other], present[other], last, step)
            _continue(path[half], last, step)
        if self._rolling:
            path[:, :, 2] = now[:, 2]  # courses are not smoothed
        smooth, rate, bend = np.einsum("dw,wnc->dnc", self._weights, path - now)
        row_now = frame % self._length
        return Reference(now + smooth, rate, bend, self._raw[row_now, id], self._shifting[row_now, id])

    def _grow(self, size):
        """Allocate memory for bodies with numbers below `size`."""
        room = ((0, 0), (0, size - self._present.shape[1]))
        self._present, self._shifting = (np.pad(self._present, room), np.pad(self._shifting, room))
        self._speed = np.pad(self._speed, room)
        self._raw, self._path = (np.pad(poses, (*room, (0, 0))) for poses in (self._raw, self._path))

    def _begin_lane_change(self, frame, id, offset):
        """Spread a jump at a frame, including frames before it."""
        change = SpreadLaneChange(id, frame, offset)
        for at in range(frame - self._lead, frame + 1):
            if at >= 0 and self._present[at % self._length, id]:
                change = self._shift(change, at)
        self._lane_changes.append(change)

    def _continue_lane_changes(self, frame):
        """Shift the bodies that change lanes at a new frame."""
        row = frame % self._length
        self._lane_changes = [
            self._shift(change, frame)
            for change in self._lane_changes
            if self._present[row, change.body] and change.progress < 1
        ]

    def _shift(self, change, frame):
        row = frame % self._length
        change = change.advanced(self._speed[row, change.body], self._change_fraction)
        course = self._path[row, change.body, 2]
        self._path[row, change.body, :2] += change.shift(frame) * np.array([-np.sin(course), np.cos(course)])
        self._shifting[row, change.body] = True
        return change


def _last(present):
    """Return the last row (N,) before the first in which bodies are missing (W, N)."""
    known: object = np.logical_and.accumulate(present, axis=0).sum(axis=0)
    return known - 1


def _straight(path, distance, last):
    """Return straight steps (N, 3) from the last known poses of (W, N, 3), of length `distance` (W, N) [m]."""
    body = np.arange(path.shape[1])
    course, length = (path[last, body, 2], distance[last, body])
    return np.column_stack([length * np.cos(course), length * np.sin(course), np.zeros(len(body))])


def _steady(path, other, other_present, last, straight):
    """Return the last known steps (N, 3), turn included; from the other side of the window if necessary."""
    body = np.arange(path.shape[1])
    step = path[last, body] - path[np.maximum(last - 1, 0), body]
    turned_around = np.where(other_present[1, :, None], path[0] - other[1], straight)
    return np.where((last > 0)[:, None], step, turned_around)


def _continue(path, last, step):
    """Extrapolate poses (W, N, 3) beyond the last known rows (N,) by steps (N, 3)."""
    ahead = np.arange(len(path))[:, None] - last
    missing = ahead > 0
    if missing.any():
        end = path[last, np.arange(len(last))]
        path[missing] = (end + ahead[:, :, None] * step)[missing]


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """Positions and derivatives of N points on their paths, at one instant each."""

    place: object
    velocity: object
    acceleration: object

    def shifted(self, time):
        """Return the path extrapolated by `time` (N,) [s] with its derivatives."""
        t = time[:, None]
        return Path(
            self.place + t * self.velocity + 0.5 * t**2 * self.acceleration,
            self.velocity + t * self.acceleration,
            self.acceleration,
        )

    def acceleration_across(self):
        """Return the lateral acceleration (N,) [m/s^2], without sign."""
        cross = self.velocity[:, 0] * self.acceleration[:, 1] - self.velocity[:, 1] * self.acceleration[:, 0]
        across: object = np.abs(cross) / np.maximum(np.hypot(*self.velocity.T), 0.1)
        return across


class Trail:
    """Ring buffer of paths, by the number of the body."""

    def __init__(self, dt, seconds):
        self._dt = dt
        self._length = max(round(seconds / dt), 2)
        self._latest = -1
        self._since = np.zeros(0, np.int64)
        self._known = np.zeros((self._length, 0, 3, 2))

    def add(self, id, new, path):
        """Add a frame: bodies `id` (N,) ascending, `new` (M,) those that were absent from the last one."""
        self._latest += 1
        if id[-1] >= len(self._since):
            room = (0, 2 * int(id[-1]) + 64 - len(self._since))
            self._since = np.pad(self._since, room)
            self._known = np.pad(self._known, ((0, 0), room, (0, 0), (0, 0)))
        self._since[new] = self._latest
        self._known[self._latest % self._length, id] = np.stack([path.place, path.velocity, path.acceleration], axis=1)

    def at(self, id, ago):
        """Return the paths of bodies (N,) `ago` (N,) [s] before the latest frame, with cubic interpolation."""
        wanted = self._latest - ago / self._dt
        first = np.maximum(self._since[id], self._latest - self._length + 1)
        before = np.clip(np.floor(wanted), first, np.maximum(self._latest - 1, first)).astype(np.int64)
        share = np.clip(wanted - before, 0.0, np.minimum(self._latest - before, 1.0))
        start = self._known[before % self._length, id]
        end = self._known[(before + 1) % self._length, id]
        s, h = (share[:, None], self._dt)
        place = (
            (1 + 2 * s) * (1 - s) ** 2 * start[:, 0]
            + s * (1 - s) ** 2 * h * start[:, 1]
            + s**2 * (3 - 2 * s) * end[:, 0]
            + s**2 * (s - 1) * h * end[:, 1]
        )
        known = Path(place, *(start[:, d] + s * (end[:, d] - start[:, d]) for d in (1, 2)))
        return known.shifted((wanted - before - share) * h)


def along_across(vector, yaw):
    """Return the components (N,) of vectors (N, 2) along yaws (N,) [rad] and to their left."""
    cos, sin = (np.cos(yaw), np.sin(yaw))
    return (vector[:, 0] * cos + vector[:, 1] * sin, vector[:, 1] * cos - vector[:, 0] * sin)


def clamp(value, limit):
    """Limit the magnitude of values (N,)."""
    cut: object = np.minimum(np.maximum(value, -limit), limit)
    return cut


@dataclass(frozen=True, slots=True, eq=False)
class Dimensions:
    """Dimensions of N bodies."""

    front_offset: object
    limit_offset: object
    yaw_rate_max: object


@dataclass(frozen=True, slots=True, eq=False)
class Rolling:
    """Motion of N bodies at one instant."""

    axle: object
    yaw: object
    speed: object
    acceleration: object
    yaw_rate: object
    yaw_acceleration: object

    def at(self, distance):
        """Return place, velocity and acceleration, (N, 2) each, of points `distance` (N,) [m] ahead of the axle."""
        u = np.column_stack([np.cos(self.yaw), np.sin(self.yaw)])
        n = np.column_stack([-u[:, 1], u[:, 0]])
        along = self.acceleration - distance * self.yaw_rate**2
        across = self.speed * self.yaw_rate + distance * self.yaw_acceleration
        return (
            self.axle + distance[:, None] * u,
            self.speed[:, None] * u + (distance * self.yaw_rate)[:, None] * n,
            along[:, None] * u + across[:, None] * n,
        )


def initialise_bodies(path, yaw, dimensions):
    """Initialise bodies with their fronts on paths, at yaws (N,) [rad], in steady motion."""
    along, across = along_across(path.velocity, yaw)
    speed = np.maximum(along, 0.0)
    steering = np.where(speed > STANDING, across / np.maximum(speed, STANDING), 0.0)
    yaw_rate = clamp(speed * steering / dimensions.front_offset, yaw_rate_limit(speed, dimensions))
    acceleration = np.clip(along_across(path.acceleration, yaw)[0], -GRIP, ACCELERATION_MAX)
    axle = path.place - dimensions.front_offset[:, None] * np.column_stack([np.cos(yaw), np.sin(yaw)])
    return Rolling(axle, yaw, speed, np.where(speed > 0, acceleration, 0.0), yaw_rate, np.zeros(len(yaw)))


def step_bodies(state, speed_wanted, curvature_wanted, feedforward, dimensions, dt):
    """Advance by one step."""
    speed, acceleration = _next_speed(state, speed_wanted, feedforward, dt)
    yaw_rate, yaw_acceleration = _next_yaw_rate(state, curvature_wanted, speed, dimensions, dt)
    distance = 0.5 * (state.speed + speed) * dt
    turn = 0.5 * (state.yaw_rate + yaw_rate) * dt
    middle, chord = (state.yaw + 0.5 * turn, distance * np.sinc(turn / (2 * np.pi)))
    axle = state.axle + chord[:, None] * np.column_stack([np.cos(middle), np.sin(middle)])
    return Rolling(axle, state.yaw + turn, speed, acceleration, yaw_rate, yaw_acceleration)


def yaw_rate_limit(speed, dimensions):
    """Return the maximum yaw rate (N,) [rad/s] at speeds (N,) [m/s]."""
    locked = speed * math.tan(STEERING) / dimensions.front_offset
    return np.minimum(np.minimum(locked, LATERAL_ACCELERATION / np.maximum(speed, 0.1)), dimensions.yaw_rate_max)


def _next_speed(state, wanted, feedforward, dt):
    """Return speed [m/s] and acceleration [m/s^2] after a step towards a target speed."""
    expected = state.speed + 0.5 * (state.acceleration + feedforward) * dt
    acceleration = feedforward + (wanted - expected) / SETTLING_S
    across = np.minimum(state.speed * np.abs(state.yaw_rate), GRIP)
    acceleration_min = -np.minimum(np.sqrt(GRIP**2 - across**2), np.sqrt(JERK * state.speed))
    acceleration = np.minimum(np.maximum(acceleration, acceleration_min), ACCELERATION_MAX)
    acceleration = state.acceleration + clamp(acceleration - state.acceleration, JERK * dt)
    speed = state.speed + 0.5 * (state.acceleration + acceleration) * dt
    stands = (speed <= 0) | (wanted == 0) & (speed < STANDING)
    return (np.where(stands, 0.0, speed), np.where(stands, 0.0, acceleration))


def _next_yaw_rate(state, curvature, speed, dimensions, dt):
    """Return yaw rate [rad/s] and yaw acceleration [rad/s^2] after a step towards a target curvature."""
    limit = yaw_rate_limit(speed, dimensions)
    error = clamp(curvature * speed, limit) - state.yaw_rate
    reach = np.maximum(np.abs(dimensions.limit_offset), 0.5)
    jerk = LATERAL_JERK / reach
    room = LATERAL_ACCELERATION + SWING_ABOVE - speed * np.abs(state.yaw_rate)
    swing = np.where(error * state.yaw_rate > 0, np.clip(room, 0.1, SWING), SWING)
    most = np.minimum(LATERAL_JERK / np.maximum(speed, 1.0), swing / reach)
    wanted = clamp(error / STEERING_S, np.minimum(most, np.sqrt(2 * jerk * np.abs(error))))
    acceleration = state.yaw_acceleration + clamp(wanted - state.yaw_acceleration, jerk * dt)
    free = state.yaw_rate + 0.5 * (state.yaw_acceleration + acceleration) * dt
    yaw_rate = clamp(free, limit)
    return (yaw_rate, np.where(yaw_rate == free, acceleration, (yaw_rate - state.yaw_rate) / dt))


def advance_bodies(state, lag, id, trail, dimensions, dt):
    """Follow paths from the previous to the latest frame."""
    steps = math.ceil(dt / STEP_S)
    for step in range(steps):
        left = dt * (steps - step - 1) / steps
        state, lag = _follow_step(state, lag, id, trail, left, dimensions, dt / steps)
    return (state, lag)


def _follow_step(state, lag, id, trail, left, dimensions, dt):
    """Follow the paths for one step, which ends `left` [s] before the latest frame."""
    front, _, _ = state.at(dimensions.front_offset)
    lag = _next_lag(lag, front, trail.at(id, left + dt + lag))
    target = trail.at(id, left + lag)
    speed = np.hypot(*target.velocity.T)
    along_error, cross_error = along_across(target.shifted(np.full(len(lag), -dt)).place - front, state.yaw)
    yaw = state.yaw + state.yaw_rate * (dt + STEERING_S)
    ahead, across = along_across(target.shifted(np.full(len(lag), STEERING_S)).velocity, yaw)
    correction = clamp(np.arctan(cross_error / (AIM_M + AIM_S * speed)), AIM_RAD)
    angle = np.arctan2(across, ahead) + correction
    reachable, angle = (np.abs(angle) <= STEERING, clamp(angle, STEERING))
    moving = speed > STANDING
    curvature = np.where(moving, np.tan(angle) / dimensions.front_offset, 0.0)
    distance_behind = np.where(moving, lag * np.maximum(speed, SLOW), along_error)
    catch_up_speed = clamp(CATCH_UP * distance_behind, np.maximum(CATCH_UP_SHARE * speed, CATCH_UP_LEAST))
    catch_up_speed = np.where(reachable, catch_up_speed, 0.0)
    wanted = np.where(
        moving,
        np.maximum(speed * np.cos(angle) + catch_up_speed, 0.0),
        np.where(catch_up_speed > CREEP, catch_up_speed, 0.0),
    )
    speed_max = _speed_limit(target, speed)
    path_acceleration = along_across(target.acceleration, yaw)[0] + across * state.yaw_rate
    feedforward = np.where(moving & reachable & (wanted < speed_max), path_acceleration, 0.0)
    return (step_bodies(state, np.minimum(wanted, speed_max), curvature, feedforward, dimensions, dt), lag)


def _next_lag(lag, front, path):
    """Return the lag (N,) [s] of fronts (N, 2), given their paths at the previous lag."""
    speed_squared = np.maximum(np.einsum("nc,nc->n", path.velocity, path.velocity), SLOW**2)
    more = np.einsum("nc,nc->n", path.place - front, path.velocity) / speed_squared
    later = np.clip(lag + clamp(more, LAG_STEP_S), -AHEAD_S, BEHIND_S)
    return np.where(speed_squared > SLOW**2, later, np.where(lag > 0, later, 0.0))


def _speed_limit(path, speed):
    """Return the maximum speed (N,) [m/s] in bends of paths with `speed` (N,); on straights, twice that."""
    across = np.maximum(path.acceleration_across(), LATERAL_ACCELERATION / 4)
    return np.maximum(speed, CATCH_UP_LEAST) * np.sqrt(LATERAL_ACCELERATION / across)


@dataclass(frozen=True, slots=True, eq=False)
class Trailing:
    """Motion of N trailers at one instant: that of the whole straight vehicle's box, along the trailer."""

    yaw: object
    yaw_rate: object
    centre: object


class Trailers:
    """The trailers of one run."""

    def __init__(self, dt):
        self._dt = dt
        self._id = np.empty(0, np.int64)

    def follow(self, id, tractor, length, hitch):
        """Return the motion of N trailers a frame later; new ones are aligned with their tractors."""
        yaw = tractor.yaw.copy()
        _, new, old = np.intersect1d(id, self._id, assume_unique=True, return_indices=True)
        if len(new):
            before, rate = (self._trailing.yaw[old], self._trailing.yaw_rate[old])
            yaw[new] = before + rate * self._dt
            yaw[new] = before + 0.5 * self._dt * (rate + trail(tractor, yaw, length, hitch).yaw_rate[new])
        self._id, self._trailing = (id, trail(tractor, yaw, length, hitch))
        return self._trailing


def trail(tractor, yaw, length, hitch):
    """Return the motion of trailers."""
    place, velocity, acceleration = tractor.at(hitch.drive_axle - hitch.kingpin)
    u = np.column_stack([np.cos(yaw), np.sin(yaw)])
    n = np.column_stack([-u[:, 1], u[:, 0]])
    base = hitch.trailer_axles - hitch.kingpin
    rate = np.einsum("nc,nc->n", velocity, n) / base
    swing = (np.einsum("nc,nc->n", acceleration, n) - rate * np.einsum("nc,nc->n", velocity, u)) / base
    ahead = (hitch.kingpin - 0.5 * length)[:, None]
    centre = (
        place + ahead * u,
        velocity + ahead * rate[:, None] * n,
        acceleration + ahead * (swing[:, None] * n - rate[:, None] ** 2 * u),
    )
    return Trailing(yaw, rate, centre)


@dataclass(frozen=True, slots=True, eq=False)
class _MemberTable:
    """Dimensions of N members."""

    id: object
    length: object
    dimensions: object
    articulated: object
    hitch: object

    @classmethod
    def of(cls, members):
        length = np.array([member.size[0] for member in members])
        kind = np.array([member.kind for member in members], np.uint8)
        articulated = np.flatnonzero(
            (kind == Kind.TRAILER_TRUCK) | ((kind == Kind.BUS) & (length > 15) & (length <= 18.75))
        )
        coupling = hitch(length[articulated], kind[articulated])
        front_offset = np.maximum(REAR_AXLE * length, SHORTEST_LEAD)
        limit_offset = front_offset - 0.5 * length
        front_offset[articulated], limit_offset[articulated] = (coupling.drive_axle, 0.0)
        walks = np.array([member.kind is Kind.PEDESTRIAN for member in members])
        dimensions = Dimensions(front_offset, limit_offset, np.where(walks, YAW_RATE_ON_FOOT, YAW_RATE_ON_WHEELS))
        return cls(np.array([member.id for member in members]), length, dimensions, articulated, coupling)


class PhysicalTruth:
    """Converter of raw frames to motions, in order, each as soon as the look-ahead allows."""

    def __init__(self, dt, config, *, rolling):
        self._dt = dt
        self._rolling = rolling
        self._ahead = round(config.lookahead_s / dt)
        self._window = Window(dt, config, rolling=rolling)
        self._waiting = deque()
        self._pushed = 0
        self._ended = False
        self._id = np.empty(0, np.int64)
        self._trail = Trail(dt, BEHIND_S + 1.0)
        self._trailers = Trailers(dt)

    def push(self, raw):
        """Append the next raw frame."""
        table = _MemberTable.of(raw.members)
        forward = 0.5 * table.length[:, None] * self._rolling
        yaw = raw.pose_world[:, 2]
        point = raw.pose_world[:, :2] + forward * np.column_stack([np.cos(yaw), np.sin(yaw)])
        walks = np.array([member.kind is Kind.PEDESTRIAN for member in raw.members])
        self._window.push(self._pushed, table.id, np.column_stack([point, yaw]), raw.speed, walks)
        self._waiting.append(raw)
        self._pushed += 1

    def end(self):
        """Mark the end of the raw frames."""
        self._ended = True

    def pop(self):
        """Return members and motion of the next final frame, or None if there is none yet."""
        if not self._waiting or (len(self._waiting) <= self._ahead and (not self._ended)):
            return None
        members = self._waiting[0].members
        table = _MemberTable.of(members)
        reference = self._window.reference(self._pushed - len(self._waiting), table.id, self._pushed)
        self._waiting.popleft()
        return (members, self._rolled(table, reference) if self._rolling else _smoothed(reference))

    def _rolled(self, table, reference):
        """Return the motion of bodies that roll along the reference."""
        path = Path(reference.path[:, :2], reference.rate[:, :2], reference.bend[:, :2])
        bodies = self._follow(table, path, reference.raw[:, 2])
        front, _, _ = bodies.at(table.dimensions.front_offset)
        place, velocity, acceleration = bodies.at(table.dimensions.front_offset - 0.5 * table.length)
        motion = Kinematics(
            pose_world=np.column_stack([place, wrap_angle(bodies.yaw)]),
            velocity_world=velocity,
            acceleration_world=acceleration,
            yaw_rate=bodies.yaw_rate.copy(),
            articulation=np.zeros(len(place)),
            changes_lane=reference.changes_lane,
            deviation=_deviation(front - reference.raw[:, :2], reference.path[:, 2]),
        )
        return self._with_trailers(table, bodies, motion) if len(table.articulated) else motion

    def _follow(self, table, path, yaw):
        """Advance the known bodies; initialise the new ones."""
        _, known, before = np.intersect1d(table.id, self._id, assume_unique=True, return_indices=True)
        new = np.setdiff1d(np.arange(len(table.id)), known, assume_unique=True)
        self._trail.add(table.id, table.id[new], path)
        bodies, lag = (
            [initialise_bodies(_rows(path, new), yaw[new], _rows(table.dimensions, new))],
            [np.zeros(len(new))],
        )
        if len(known):
            dimensions = _rows(table.dimensions, known)
            rolled = advance_bodies(
                _rows(self._bodies, before), self._next_lag[before], table.id[known], self._trail, dimensions, self._dt
            )
            bodies.append(rolled[0])
            lag.append(rolled[1])
        order = np.argsort(np.concatenate([new, known]))
        self._id, self._next_lag = (table.id, np.concatenate(lag)[order])
        self._bodies = Rolling(
            *(np.concatenate([getattr(part, column.name) for part in bodies])[order] for column in fields(Rolling))
        )
        return self._bodies

    def _with_trailers(self, table, bodies, motion):
        """Replace the motion of tractors by that of their trailers."""
        rows = table.articulated
        tractor = _rows(bodies, rows)
        trailing = self._trailers.follow(table.id[rows], tractor, table.length[rows], table.hitch)
        place, velocity, acceleration = trailing.centre
        motion.pose_world[rows] = np.column_stack([place, wrap_angle(trailing.yaw)])
        motion.velocity_world[rows] = velocity
        motion.acceleration_world[rows] = acceleration
        motion.yaw_rate[rows] = trailing.yaw_rate
        motion.articulation[rows] = wrap_angle(tractor.yaw - trailing.yaw)
        return motion


def _smoothed(reference):
    """Return the motion of the smoothed poses."""
    return Kinematics(
        pose_world=np.column_stack([reference.path[:, :2], wrap_angle(reference.path[:, 2])]),
        velocity_world=reference.rate[:, :2],
        acceleration_world=reference.bend[:, :2],
        yaw_rate=reference.rate[:, 2],
        articulation=np.zeros(len(reference.path)),
        changes_lane=reference.changes_lane,
        deviation=_deviation(reference.path[:, :2] - reference.raw[:, :2], reference.path[:, 2]),
    )


def _deviation(offset, course):
    """Return the components of offsets (N, 2) along and to the left of courses (N,)."""
    cos, sin = (np.cos(course), np.sin(course))
    return np.column_stack([offset[:, 0] * cos + offset[:, 1] * sin, offset[:, 1] * cos - offset[:, 0] * sin])


def _rows(record, rows):
    return replace(record, **{column.name: getattr(record, column.name)[rows] for column in fields(record)})
