"""Ground truth of a recorded scan, from its labels: which points are on which vehicle."""

import numpy as np

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.dataset.dataset_columns import Values
from luxloop.scenarios.grading.plane_geometry import turned
from luxloop.sensor_model.truth import NO_ACTOR, Cause, Part, ScanTruth, View
from luxloop.sim.world import Actors, Ego, WorldFrame
from luxloop.tracker.scan import Scan

MARGIN_M = 0.3
"""[m] A point this far outside a box is on its vehicle: range noise, mirrors, and the error of the recorded pose."""


def actors_of(labels: Values) -> Actors:
    """Return the labels of one scan as actors. What a recording does not hold is 0."""
    count = len(labels["frame"])
    zero = np.zeros(count)
    return Actors(
        id=labels["actor_id"],
        name=np.array(labels["name"].tolist(), dtype=np.str_),
        kind=labels["kind"].astype(np.uint8),
        pose_world=_stack(labels, ("x_world_m", "y_world_m", "heading_world_rad")),
        velocity_world=_stack(labels, ("vx_world_mps", "vy_world_mps")),
        acceleration_world=_stack(labels, ("ax_world_mps2", "ay_world_mps2")),
        yaw_rate=labels["yaw_rate_radps"],
        articulation=zero,
        mode=labels["mode"].astype(np.uint8),
        changes_lane=np.zeros(count, dtype=np.bool_),
        deviation=np.zeros((count, 2)),
        ground_z=np.zeros(count),
        attitude=np.zeros((count, 2)),
        size=_stack(labels, ("length_m", "width_m", "height_m")),
        reflectivity=zero,
    )


def world_frame(index: int, scan: Scan, velocity: Floats, yaw_rate: float, size: Floats, actors: Actors) -> WorldFrame:
    """Return the frame of a scan; the world is the odometry frame.

    Parameters
    ----------
    velocity, yaw_rate
        (2,) of the ego in the odometry frame [m/s], and [rad/s].
    size
        (3,) of the ego [m].
    """
    ego = Ego(
        pose_world=scan.ego_pose_odom,
        velocity_world=velocity,
        acceleration_world=np.zeros(2),
        yaw_rate=yaw_rate,
        size=size,
        changes_lane=False,
        deviation=np.zeros(2),
        ground_z=0.0,
        attitude=np.zeros(2),
    )
    return WorldFrame(index, scan.time, ego, actors)


def scan_truth(scan: Scan, frame: WorldFrame) -> ScanTruth:
    """Assign the points of a scan to the vehicles whose boxes they are in; all points count as clean.

    Occluders are not known: a vehicle with points is visible, one without is hidden.
    """
    actor_row = _actor_rows(scan, frame)
    on = actor_row >= 0
    count = len(frame.actors)
    hits = np.bincount(actor_row[on], minlength=count).astype(np.int32)[:, None]
    points = scan.points_ego.astype(np.float64)
    return ScanTruth(
        actor_id=np.append(frame.actors.id, NO_ACTOR)[actor_row],
        part=np.where(on, Part.BODY, Part.NONE).astype(np.uint8),
        cause=np.full(len(scan), Cause.CLEAN, dtype=np.uint8),
        true_range=np.sqrt((points**2).sum(axis=1)).astype(np.float32),
        lost_unit=np.empty(0, np.uint8),
        lost_beam=np.empty(0, np.int32),
        lost_cause=np.empty(0, np.uint8),
        unit_hits=hits,
        unit_hits_alone=hits,
        faces=np.zeros(count, dtype=np.uint8),
        view=np.full(count, View.NONE, dtype=np.uint8),
    )


def _actor_rows(scan: Scan, frame: WorldFrame) -> Ints:
    """(N,) row of the vehicle whose box each point is in at the point's own time, -1 for none."""
    ego, actors, dt = frame.ego, frame.actors, scan.time_offset.astype(np.float64)
    yaw = ego.pose_world[2] + ego.yaw_rate * dt
    points = turned(scan.points_ego[:, :2].astype(np.float64), yaw)
    points += ego.pose_world[:2] + dt[:, None] * ego.velocity_world
    row = np.full(len(scan), -1, dtype=np.int64)
    for k in range(len(actors)):
        heading = actors.pose_world[k, 2] + actors.yaw_rate[k] * dt
        body = turned(points - actors.pose_world[k, :2] - dt[:, None] * actors.velocity_world[k], -heading)
        row[(np.abs(body) <= 0.5 * actors.size[k, :2] + MARGIN_M).all(axis=1)] = k
    return row


def _stack(values: Values, names: tuple[str, ...]) -> Floats:
    return np.stack([values[name] for name in names], axis=1)
