"""A synthetic drive for tests of grading, recording and export: six vehicles around the ego, tracked without error.

The ego starts far from the world's origin, rotated, and drives straight. Odometry drifts, and the tracks with it.
Track n follows actor 100 + n. Actor 100 is hidden, and its track coasts, in the frames of `HIDDEN`.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from luxloop.scenarios.grading.frame_truth import FrameGrade
from luxloop.sensor_model.truth import NO_ACTOR, Cause, Part, ScanTruth
from luxloop.sim.world import Actors, Ego, Kind, Mode, Obstacles, WorldFrame
from luxloop.tracker.records import METHODS, Boxes, Candidates, Linkage, Segments, Status, StepTrace, Tracks
from luxloop.tracker.scan import Scan

Floats = npt.NDArray[np.float64]

DT = 0.08
START = np.array([52_000.25, 31_000.5, 0.6])
EGO_MPS = 8.0
LANE = np.array([[14.0, -3.5], [30.0, 0.0], [-16.0, -3.5], [40.0, 3.5], [24.0, 7.0], [10.0, 6.0]])
SPEED = np.array([9.0, 7.0, 10.0, -8.0, -9.0, 0.0])
YAW = np.where(SPEED < 0, np.pi, 0.0)
KIND = np.array([Kind.CAR, Kind.TRUCK, Kind.CAR, Kind.CAR, Kind.VAN, Kind.CAR], dtype=np.uint8)
SIZE = np.array([[4.5, 1.8, 1.5], [9.0, 2.5, 3.4], [4.5, 1.8, 1.5], [4.3, 1.7, 1.5], [5.4, 2.0, 2.3], [4.5, 1.8, 1.4]])
COUNT = len(LANE)
IDS = np.arange(COUNT) + 100
TENTATIVE, HIDDEN = range(3), range(10, 20)
"""Frames in which all tracks are tentative, and in which actor 100 is hidden."""


class Step(NamedTuple):
    """Records that the run loop passes to the recorder."""

    frame: WorldFrame
    scan: Scan
    scan_truth: ScanTruth
    tracks: Tracks
    trace: StepTrace
    grade: FrameGrade


def drive(frames: int, points: int = 300) -> Iterator[Step]:
    """Yield frames; two thirds of the points lie on vehicles."""
    rng = np.random.default_rng(7)
    for index in range(frames):
        ego = np.array([EGO_MPS * index * DT, 0.0, 0.0])
        drifted = ego + index * np.array([0.02, -0.01, 0.002])
        place = LANE + np.outer(SPEED * index * DT, [1.0, 0.0])
        place_ego = place - ego[:2]
        hidden = (IDS[0] == IDS) & (index in HIDDEN)
        scan, truth = _scan(rng, drifted, place_ego, points)
        boxes = _fits(place_ego[~hidden], SIZE[~hidden])
        yield Step(
            frame=WorldFrame(index, index * DT, _ego(ego), _actors(place)),
            scan=scan,
            scan_truth=truth,
            tracks=_tracks(place_ego, drifted, hidden, index),
            trace=_trace(boxes, len(scan)),
            grade=FrameGrade(
                graded=~hidden,
                points=truth.hits.astype(np.int64),
                track_actor=IDS,
                track_heading_error=np.deg2rad([1.0, -2.0, 3.0, -4.0, 5.0, 6.0]),
                box_actor=IDS[~hidden],
                box_heading_error=np.deg2rad(np.full(len(boxes), -0.5)),
            ),
        )


def turned(xy: Floats, yaw: float) -> Floats:
    """Rotate vectors (N, 2) counter-clockwise."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    return xy @ np.array([[cos, sin], [-sin, cos]])


def buildings() -> Obstacles:
    """Return a house and a wall near the start."""
    house = START[:2] + np.array([[20.0, 40.0], [45.0, 40.0], [45.0, 60.0], [20.0, 60.0]])
    wall = START[:2] + np.array([[-10.0, -20.0], [30.0, -20.0]])
    return Obstacles.from_polygons([house, wall], height=[9.0, 1.0])


def _ego(ego: Floats) -> Ego:
    place = START[:2] + turned(ego[None, :2], START[2])[0]
    velocity = turned(np.array([[EGO_MPS, 0.0]]), START[2])[0]
    return Ego(
        np.append(place, START[2]),
        velocity,
        np.zeros(2),
        0.0,
        np.array([4.4, 1.8, 1.5]),
        False,
        np.zeros(2),
        0.0,
        np.zeros(2),
    )


def _actors(place: Floats) -> Actors:
    return Actors(
        id=IDS,
        name=np.array([f"flow.{index}" for index in range(COUNT)]),
        kind=KIND,
        pose_world=np.column_stack([START[:2] + turned(place, START[2]), YAW + START[2]]),
        velocity_world=turned(np.outer(SPEED, [1.0, 0.0]), START[2]),
        acceleration_world=np.zeros((COUNT, 2)),
        yaw_rate=np.zeros(COUNT),
        articulation=np.zeros(COUNT),
        mode=np.where(SPEED == 0, Mode.STATIONARY, Mode.CONSTANT_VELOCITY).astype(np.uint8),
        changes_lane=np.zeros(COUNT, np.bool_),
        deviation=np.zeros((COUNT, 2)),
        ground_z=np.zeros(COUNT),
        attitude=np.zeros((COUNT, 2)),
        size=SIZE,
        reflectivity=np.full(COUNT, 0.3),
    )


def _scan(rng: np.random.Generator, ego_pose_odom: Floats, place: Floats, points: int) -> tuple[Scan, ScanTruth]:
    """Return points on the vehicles, a quarter of them noise, and half as many on no actor."""
    background = points // 3
    actor = rng.integers(0, COUNT, points - background)
    on_actor = place[actor] + 0.5 * SIZE[actor, :2] * rng.uniform(-1.0, 1.0, (len(actor), 2))
    clutter = rng.uniform(-50.0, 50.0, (background, 2))
    xyz = np.column_stack([np.vstack([on_actor, clutter]), rng.uniform(0.2, 1.4, points)])
    cause = np.where(rng.random(points) < 0.75, Cause.CLEAN, rng.integers(1, len(Cause), points))
    cause[len(actor) :] = Cause.CLEAN
    hits = np.bincount(actor, minlength=COUNT).astype(np.int32)
    scan = Scan(
        time=0.0,
        ego_pose_odom=ego_pose_odom,
        points_ego=xyz.astype(np.float32),
        time_offset=np.zeros(points, np.float32),
        unit=rng.integers(0, 6, points).astype(np.uint8),
        layer=rng.integers(0, 4, points).astype(np.uint8),
        echo=np.zeros(points, np.uint8),
        echo_pulse_width=np.ones(points, np.float32),
        flags=np.zeros(points, np.uint16),
    )
    truth = ScanTruth(
        actor_id=np.append(IDS[actor], np.full(background, NO_ACTOR)),
        part=np.full(points, Part.BODY, np.uint8),
        cause=cause.astype(np.uint8),
        true_range=np.linalg.norm(xyz, axis=1).astype(np.float32),
        lost_unit=np.empty(0, np.uint8),
        lost_beam=np.empty(0, np.int32),
        lost_cause=np.empty(0, np.uint8),
        unit_hits=hits[:, None],
        unit_hits_alone=hits[:, None] * np.array([[2], [1], [1], [1], [1], [1]], np.int32),
        faces=np.zeros(COUNT, np.uint8),
        view=np.zeros(COUNT, np.uint8),
    )
    return scan, truth


def _fits(place_ego: Floats, size: Floats) -> Boxes:
    count = len(place_ego)
    return Boxes(
        segment=np.arange(count),
        center_ego=place_ego,
        heading=np.full(count, 0.01),
        size=size[:, :2],
        corner_ego=place_ego,
        corner_sign=np.ones((count, 2), np.int64),
        covariance=np.zeros((count, 3, 3)),
        support=np.full(count, 10),
        time_offset=np.zeros(count),
        cut=np.zeros((count, 2, 2), dtype=np.bool_),
        flat=np.zeros(count, dtype=np.bool_),
        viewpoint_ego=np.zeros((count, 2)),
    )


def _tracks(place_ego: Floats, ego_pose_odom: Floats, hidden: npt.NDArray[np.bool_], index: int) -> Tracks:
    """Return tracks 0 to 5 exactly on the actors, by their front left corners, in the drifting odometry frame."""
    front_left = 0.5 * SIZE[:, :2] * np.where(SPEED < 0, -1.0, 1.0)[:, None]
    mean = np.zeros((COUNT, 8))
    mean[:, :2] = ego_pose_odom[:2] + turned(place_ego + front_left, ego_pose_odom[2])
    mean[:, 2:4] = turned(np.outer(SPEED, [1.0, 0.0]), ego_pose_odom[2])
    mean[:, 6] = YAW + ego_pose_odom[2]
    seen = Status.TENTATIVE if index in TENTATIVE else Status.CONFIRMED
    return Tracks(
        id=np.arange(COUNT),
        status=np.where(hidden, Status.COASTING, seen).astype(np.uint8),
        mean=mean,
        covariance=np.zeros((COUNT, 8, 8)),
        model_probability=np.where((SPEED == 0)[:, None], [0.9, 0.06, 0.04], [0.1, 0.7, 0.2]),
        model=np.where(SPEED == 0, 0, 1),
        model_position_odom=np.zeros((COUNT, 3, 2)),
        corner_sign=np.ones((COUNT, 2), np.int64),
        size=SIZE[:, :2],
    )


def _trace(boxes: Boxes, points: int) -> StepTrace:
    count = len(boxes)
    zeros: Any = np.zeros((count, len(METHODS)))
    return StepTrace(
        segments=Segments(np.full(points, -1), count),
        linkage=Linkage(np.full(points, -1), np.zeros(count)),
        candidates=Candidates(zeros, zeros[..., None], zeros[..., None], zeros, np.zeros(count, np.int64)),
        boxes=boxes,
        track_id=np.arange(count),
    )
