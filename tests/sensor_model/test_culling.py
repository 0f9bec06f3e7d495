"""Bounds of culling: they hold every direction of a moving object from a moving unit, motion by motion.

A scene with all motions at once has the margin of one motion cover the missing margin of another.
"""

import numpy as np
import pytest

from luxloop.sensor_model.kernels.culling import body_intervals, wall_intervals
from luxloop.sensor_model.kernels.records import EgoDrive

TIME = 0.04
"""[s] Half a scan of the LUX: the largest time between the firing of a beam and the frame's time."""
INSTANTS = np.linspace(-TIME, TIME, 9)
STILL = {"velocity": 0.0, "acceleration": 0.0, "yaw_rate": 0.0}
STRENGTH = {"velocity": 30.0, "acceleration": 8.0, "yaw_rate": 1.1}
MOTIONS = [(mover, motion) for mover in ("ego", "object") for motion in STRENGTH]
FAR = 1000.0


def turned(vector, yaw):
    """Rotate vectors (..., 2) by an angle [rad]."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    return np.asarray(vector) @ np.array([[cos, sin], [-sin, cos]])


def scene(rng, mover, motion):
    """Return a unit at a corner of the ego, and ego and object with one motion of one of them, in random directions."""
    signs, heading = rng.choice([-1.0, 1.0], 2), rng.uniform(-np.pi, np.pi)
    rates = {name: dict(STILL) for name in ("ego", "object")}
    rates[mover][motion] = STRENGTH[motion]
    course = turned([1.0, 0.0], heading)
    drive = rates["ego"]
    ego = EgoDrive(*(drive["velocity"] * course), *(drive["acceleration"] * course), signs[0] * drive["yaw_rate"])
    own = rates["object"]
    bearing, distance = rng.uniform(-np.pi, np.pi), rng.uniform(9.0, 25.0)
    pose = [*turned([distance, 0.0], bearing), rng.uniform(-np.pi, np.pi)]
    body = np.array([[*pose, *(own["velocity"] * course), *(own["acceleration"] * course), signs[1] * own["yaw_rate"]]])
    yaw = rng.uniform(-np.pi, np.pi)
    rotation = np.eye(3)
    rotation[:2, :2] = turned(np.eye(2), yaw).T
    origin = np.array([*(rng.choice([-1.0, 1.0], 2) * [2.2, 0.8]), 0.6])
    return origin, rotation, ego, body


def corners_at(body, box, time):
    """Return the corners (4, 2) of a body's box in plan at a time, in the ego frame of the frame's time."""
    x, y, yaw, vx, vy, ax, ay, rate = body
    corners = [[box[i, 0], box[j, 1]] for i in (0, 1) for j in (0, 1)]
    centre = np.array([x, y]) + time * np.array([vx, vy]) + 0.5 * time**2 * np.array([ax, ay])
    return centre + turned(corners, yaw + rate * time)


def azimuths(places, origin, rotation, ego, time):
    """Return the azimuths (N,) of places (N, 2) from a unit that moves with the ego [rad]."""
    moved = time * np.array(ego[:2]) + 0.5 * time**2 * np.array(ego[2:4])
    seen = turned(places - moved, -ego.yaw_rate * time) - origin[:2]
    x, y = (seen @ rotation[:2, :2]).T
    return np.arctan2(y, x)


def assert_holds(interval, azimuth):
    low, high = interval
    beyond = np.remainder(azimuth - low, 2.0 * np.pi)
    assert np.all((beyond <= high - low + 1e-9) | (beyond >= 2.0 * np.pi - 1e-9)), (low, high, azimuth)


@pytest.mark.parametrize(("mover", "motion"), MOTIONS)
def test_interval_of_a_body_holds_its_corners_at_every_firing_time(mover, motion):
    rng = np.random.default_rng(5)
    bounds = np.array([[[-2.3, -0.9, 0.0], [2.3, 0.9, 1.5]]])
    for _ in range(200):
        origin, rotation, ego, body = scene(rng, mover, motion)
        interval = np.empty((1, 2))
        body_intervals(body, bounds, origin, rotation, FAR, 0.0, TIME, ego, interval)
        for time in INSTANTS:
            assert_holds(
                interval[0], azimuths(corners_at(body[0], bounds[0, :, :2], time), origin, rotation, ego, time)
            )


@pytest.mark.parametrize("motion", STRENGTH)
def test_interval_of_a_wall_holds_its_ends_at_every_firing_time(motion):
    rng = np.random.default_rng(6)
    for _ in range(200):
        origin, rotation, ego, body = scene(rng, "ego", motion)
        ends = corners_at(body[0], np.array([[-3.0, 0.0], [3.0, 0.0]]), 0.0)[[0, 3]]
        interval = np.empty((1, 2))
        z = np.array([[0.0, 3.0]])
        wall_intervals(ends.reshape(1, 4), z, origin, rotation, FAR, 0.0, TIME, ego, interval)
        for time in INSTANTS:
            assert_holds(interval[0], azimuths(ends, origin, rotation, ego, time))


@pytest.mark.parametrize(("mover", "motion"), MOTIONS)
def test_body_that_comes_into_range_during_the_scan_is_kept(mover, motion):
    """Fails if the range leaves out a margin of the motion."""
    rng = np.random.default_rng(7)
    bounds = np.array([[[-9.0, -1.3, 0.0], [9.0, 1.3, 3.0]]])
    for _ in range(200):
        origin, rotation, ego, body = scene(rng, mover, motion)
        nearest = min(distance(corners_at(body[0], bounds[0, :, :2], t), origin, ego, t) for t in INSTANTS)
        interval = np.empty((1, 2))
        body_intervals(body, bounds, origin, rotation, nearest + 1e-6, 0.0, TIME, ego, interval)
        assert np.isfinite(interval).all() or np.isinf(interval).all()


@pytest.mark.parametrize("motion", STRENGTH)
def test_wall_that_comes_into_range_during_the_scan_is_kept(motion):
    rng = np.random.default_rng(8)
    for _ in range(200):
        origin, rotation, ego, body = scene(rng, "ego", motion)
        ends = corners_at(body[0], np.array([[-3.0, 0.0], [3.0, 0.0]]), 0.0)[[0, 3]]
        nearest = min(distance(ends, origin, ego, time) for time in INSTANTS)
        interval, z = np.empty((1, 2)), np.array([[0.0, 3.0]])
        wall_intervals(ends.reshape(1, 4), z, origin, rotation, nearest + 1e-6, 0.0, TIME, ego, interval)
        assert not np.isnan(interval).any()


def distance(places, origin, ego, time):
    """Return the distance [m] of the nearest of some places (N, 2) from a unit that moves with the ego."""
    moved = time * np.array(ego[:2]) + 0.5 * time**2 * np.array(ego[2:4])
    seen = turned(places - moved, -ego.yaw_rate * time) - origin[:2]
    return np.linalg.norm(seen, axis=1).min()
