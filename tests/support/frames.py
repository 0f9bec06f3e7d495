"""Builders of hand-made scenes: frames, scans with their truth, traces and tracks.

Plane geometry uses complex numbers, independently of tracker and grader.
"""

import cmath
import math
from dataclasses import dataclass, replace

import numpy as np

from luxloop.scenarios.grading.grader import Grader
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.run import device
from luxloop.sensor_model.truth import NO_ACTOR, Cause, Part, ScanTruth, View
from luxloop.sim.world import JOINTS, Actors, Ego, Kind, Mode, WorldFrame
from luxloop.tracker.records import (
    METHODS,
    MODELS,
    Boxes,
    Candidates,
    Linkage,
    Segments,
    Status,
    StepTrace,
    Tracks,
)
from luxloop.tracker.scan import Scan

DT = 0.08
CAR_SIZE = (4.6, 1.8, 1.5)
STRAIGHT = (0.0,) * len(METHODS)


@dataclass(frozen=True)
class Body:
    """Actor of one frame."""

    id: int
    x: float
    y: float
    yaw: float = 0.0
    speed: float = 0.0
    mode: Mode | None = None
    """Default by speed: stationary or constant velocity."""
    size: tuple[float, float, float] = CAR_SIZE
    kind: Kind = Kind.CAR
    points: int = 20
    """Number of scan points on it."""
    visible: float = 1.0
    """Beams that end on it, out of `hits_alone`."""
    alone: int = 100
    """Beams that would end on it if it were alone."""
    view: View = View.L_SHAPE
    articulation: float = 0.0
    further_articulation: tuple[float, ...] = (0.0,) * (JOINTS - 1)
    acceleration: tuple[float, float] = (0.0, 0.0)
    yaw_rate: float = 0.0


def compose(frame, pose):
    """Transform a pose (x, y, yaw) from `frame` to the parent of `frame`."""
    at = complex(*frame[:2]) + complex(*pose[:2]) * cmath.exp(1j * frame[2])
    return np.array([at.real, at.imag, math.remainder(frame[2] + pose[2], math.tau)])


def express(frame, pose):
    """Transform a pose to `frame`, both given in the same parent frame."""
    at = (complex(*pose[:2]) - complex(*frame[:2])) * cmath.exp(-1j * frame[2])
    return np.array([at.real, at.imag, math.remainder(pose[2] - frame[2], math.tau)])


def world_frame(index, bodies, ego=(0.0, 0.0, 0.0), dt=DT):
    bodies = sorted(bodies, key=lambda body: body.id)
    n = len(bodies)
    velocity = [cmath.rect(body.speed, body.yaw) for body in bodies]
    return WorldFrame(
        index=index,
        time=index * dt,
        ego=Ego(
            pose_world=np.array(ego, dtype=float),
            velocity_world=np.zeros(2),
            acceleration_world=np.zeros(2),
            yaw_rate=0.0,
            size=np.array([4.8, 1.9, 1.7]),
            changes_lane=False,
            deviation=np.zeros(2),
            ground_z=0.0,
            attitude=np.zeros(2),
        ),
        actors=Actors(
            id=np.array([body.id for body in bodies], dtype=np.int64),
            name=np.array([f"car{body.id}" for body in bodies], dtype=np.str_),
            kind=np.array([body.kind for body in bodies], dtype=np.uint8),
            pose_world=np.array([(body.x, body.y, body.yaw) for body in bodies]).reshape(n, 3),
            velocity_world=np.array([(v.real, v.imag) for v in velocity]).reshape(n, 2),
            acceleration_world=np.array([body.acceleration for body in bodies], dtype=float).reshape(n, 2),
            yaw_rate=np.array([body.yaw_rate for body in bodies], dtype=float),
            articulation=np.array([body.articulation for body in bodies], dtype=float),
            further_articulation=np.array([body.further_articulation for body in bodies]).reshape(n, JOINTS - 1),
            mode=np.array([_mode(body) for body in bodies], dtype=np.uint8),
            changes_lane=np.zeros(n, np.bool_),
            deviation=np.zeros((n, 2)),
            ground_z=np.zeros(n),
            attitude=np.zeros((n, 2)),
            size=np.array([body.size for body in bodies], dtype=float).reshape(n, 3),
            reflectivity=np.full(n, 0.4),
        ),
    )


def _mode(body):
    if body.mode is not None:
        return body.mode
    return Mode.CONSTANT_VELOCITY if body.speed else Mode.STATIONARY


def observe(frame, bodies, ego_pose_odom=(0.0, 0.0, 0.0), noise=()):
    """Return a scan with each body's points at its centre, and its truth; `noise` adds (actor id, cause) points."""
    bodies = sorted(bodies, key=lambda body: body.id)
    owner = [body.id for body in bodies for _ in range(body.points)] + [actor for actor, _ in noise]
    cause = [Cause.CLEAN] * (len(owner) - len(noise)) + [cause for _, cause in noise]
    n = len(owner)
    center = {b.id: express(frame.ego.pose_world, (b.x, b.y, b.yaw)) for b in bodies}
    center[NO_ACTOR] = np.array([30.0, 30.0, 0.0])
    scan = Scan(
        time=frame.time,
        ego_pose_odom=np.array(ego_pose_odom, dtype=float),
        points_ego=np.array([(*center[i][:2], 0.5) for i in owner], dtype=np.float32).reshape(n, 3),
        time_offset=np.zeros(n, dtype=np.float32),
        unit=np.zeros(n, dtype=np.uint8),
        layer=np.zeros(n, dtype=np.uint8),
        echo=np.zeros(n, dtype=np.uint8),
        echo_pulse_width=np.ones(n, dtype=np.float32),
        flags=np.zeros(n, dtype=np.uint16),
    )
    truth = ScanTruth(
        actor_id=np.array(owner, dtype=np.int64),
        part=np.full(n, Part.BODY, dtype=np.uint8),
        cause=np.array(cause, dtype=np.uint8),
        true_range=np.ones(n, dtype=np.float32),
        lost_unit=np.empty(0, dtype=np.uint8),
        lost_beam=np.empty(0, dtype=np.int32),
        lost_cause=np.empty(0, dtype=np.uint8),
        unit_hits=np.array([[round(body.alone * body.visible)] for body in bodies], dtype=np.int32).reshape(-1, 1),
        unit_hits_alone=np.array([[body.alone] for body in bodies], dtype=np.int32).reshape(-1, 1),
        faces=np.zeros(len(bodies), dtype=np.uint8),
        view=np.array([body.view for body in bodies], dtype=np.uint8),
    )
    return scan, truth


def trace_of(frame, truth, label=None, turn_deg=STRAIGHT, line=None, best=2):
    """Return a trace whose rectangles are the true boxes, rotated by `turn_deg`, one value per method.

    Without `label` (N,) every actor is a separate segment; segment s is then fitted to the actor most seen in it.
    """
    n = len(truth.actor_id)
    ids = frame.actors.id.tolist()
    if label is None:
        label = [ids.index(actor) if actor in ids else -1 for actor in truth.actor_id.tolist()]
    label = np.array(label, dtype=np.int64)
    count = int(label.max(initial=-1)) + 1
    segments = Segments(label=label, count=count)
    center, heading, size = np.zeros((count, 2)), np.zeros(count), np.ones((count, 2))
    for s in range(count):
        held = [actor for actor in truth.actor_id[label == s].tolist() if actor != NO_ACTOR]
        if held:
            row = ids.index(max(sorted(set(held)), key=held.count))
            pose = express(frame.ego.pose_world, frame.actors.pose_world[row])
            center[s], heading[s], size[s] = pose[:2], pose[2], frame.actors.size[row, :2]
    turned = heading[:, None] + np.radians(turn_deg)
    candidates = Candidates(
        heading=turned,
        center_ego=np.repeat(center[:, None], len(METHODS), axis=1),
        size=np.repeat(size[:, None], len(METHODS), axis=1),
        cost=np.ones((count, len(METHODS))),
        best=np.full(count, best, dtype=np.int64),
    )
    boxes = Boxes(
        segment=np.arange(count),
        center_ego=center,
        heading=turned[:, best],
        size=size,
        corner_ego=center,
        corner_sign=np.ones((count, 2), dtype=np.int64),
        covariance=np.tile(np.eye(3), (count, 1, 1)),
        support=np.full(count, 10),
        time_offset=np.zeros(count),
        cut=np.zeros((count, 2, 2), dtype=np.bool_),
        flat=np.zeros(count, dtype=np.bool_),
        viewpoint_ego=np.zeros((count, 2)),
    )
    line = np.zeros(n, dtype=np.int64) if line is None else np.array(line, dtype=np.int64)
    return StepTrace(segments, Linkage(line, heading), candidates, boxes, np.arange(count))


@dataclass(frozen=True)
class Estimate:
    """Track of one frame: its reported box, in the odometry frame."""

    id: int
    x: float
    y: float
    heading: float = 0.0
    size: tuple[float, float] = CAR_SIZE[:2]
    corner: tuple[int, int] = (1, 1)
    status: Status = Status.CONFIRMED
    model: int = 1
    position_variance: float = 0.01
    model_offset: tuple[complex, complex, complex] = (0j, 0j, 0j)
    """Offset of the tracked corner for each single model."""
    velocity: tuple[float, float] = (0.0, 0.0)
    """Of the tracked corner, as the acceleration."""
    acceleration: tuple[float, float] = (0.0, 0.0)
    small: bool | None = None
    """Class of the track, if the tracker reports classes: the same for all tracks of a script."""


def tracks_of(estimates):
    n, labelled = len(estimates), any(e.small is not None for e in estimates)
    mean, covariance = np.zeros((n, 8)), np.tile(np.eye(8), (n, 1, 1))
    model_position = np.zeros((n, len(MODELS), 2))
    for t, e in enumerate(estimates):
        corner = compose((e.x, e.y, e.heading), (*(0.5 * np.array(e.corner) * e.size), 0.0))
        mean[t, :2], mean[t, 2:4], mean[t, 4:6], mean[t, 6] = corner[:2], e.velocity, e.acceleration, e.heading
        covariance[t] *= e.position_variance
        model_position[t] = [(corner[0] + o.real, corner[1] + o.imag) for o in e.model_offset]
    return Tracks(
        id=np.array([e.id for e in estimates], dtype=np.int64),
        status=np.array([e.status for e in estimates], dtype=np.uint8),
        mean=mean,
        covariance=covariance,
        model_probability=np.eye(len(MODELS))[[e.model for e in estimates]].reshape(n, len(MODELS)),
        model=np.array([e.model for e in estimates], dtype=np.int64),
        model_position_odom=model_position,
        corner_sign=np.array([e.corner for e in estimates], dtype=np.int64).reshape(n, 2),
        size=np.array([e.size for e in estimates], dtype=float).reshape(n, 2),
        small=np.array([bool(e.small) for e in estimates], dtype=np.bool_) if labelled else None,
    )


def follow(body, track_id=None, **changes):
    """Return a perfect estimate of a body, for an ego at the origin of world and odometry frame."""
    track_id = body.id if track_id is None else track_id
    velocity = cmath.rect(body.speed, body.yaw)
    estimate = Estimate(track_id, body.x, body.y, body.yaw, body.size[:2], velocity=(velocity.real, velocity.imag))
    return replace(estimate, **changes)


def drive(x, y, yaw, speed, index, dt=DT):
    """Return the position in frame `index` of a body that starts at (x, y) and drives straight."""
    at = complex(x, y) + cmath.rect(speed * index * dt, yaw)
    return at.real, at.imag


def still(_):
    """Return the poses of an ego at rest at the origin, with exact odometry."""
    return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)


def make_frames(scene, ego=still):
    """Return the frames of a scene: a list of bodies per frame; `ego(index)` gives its true and its odometry pose."""
    return [world_frame(i, bodies, ego(i)[0]) for i, bodies in enumerate(scene)]


def grade_run(scene, tracker, ego=still, config=None, trace=None):
    """Grade a tracker on a scene; `trace(frame, truth)` makes its trace. Returns metrics, tables, frame grades."""
    grader = Grader(config or GradingConfig())
    grades = []
    for index, (bodies, frame) in enumerate(zip(scene, make_frames(scene, ego), strict=True)):
        scan, truth = observe(frame, bodies, ego(index)[1])
        device.show_truth(tracker, frame, truth)
        answer = tracker.step(scan)
        tracks = answer if isinstance(answer, Tracks) else answer[0]
        grades.append(grader.add(frame, scan, truth, tracks, trace(frame, truth) if trace else None))
    return *grader.finish(), grades


@dataclass
class Scripted:
    """Tracker that reports given estimates, frame by frame, in the odometry frame."""

    script: list
    index: int = -1

    def step(self, _):
        self.index += 1
        return tracks_of(self.script[self.index]), None
