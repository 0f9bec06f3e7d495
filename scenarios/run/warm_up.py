"""Warm-up: compile the numba kernels, by calling them once, before the time measurement starts."""

import numpy as np

from scenarios.run.guard import Guard
from sensor_model.lidar import Lidar
from sensor_model.noise.noise_config import NoiseConfig
from sensor_model.rig.rig import Rig
from sensor_model.sensor_config import SensorConfig
from sim.world import Actors, Ego, Kind, Obstacles, WorldFrame

FRAMES = 3
"""Enough to start, update and confirm a track."""


def warm_up(rig: Rig, noise: NoiseConfig, sensor: SensorConfig, unused: Guard) -> None:
    """Run a LIDAR and a tracker, neither of them used again, on one car for a few frames."""
    wall = np.array([[-20.0, 15.0], [20.0, 15.0]])
    lidar = Lidar(rig, noise, sensor, seed=0, obstacles=Obstacles.from_polygons([wall], [3.0]))
    for index in range(FRAMES):
        frame = _car_ahead(index)
        scan, truth = lidar.scan(frame)
        unused.show_truth(frame, truth)
        unused.checked(unused.step(scan), scan)


def _car_ahead(index: int) -> WorldFrame:
    """Return a frame with a turning car, 8 m in front of a standing ego."""
    ego = Ego(
        pose_world=np.zeros(3),
        velocity_world=np.zeros(2),
        acceleration_world=np.zeros(2),
        yaw_rate=0.0,
        size=np.array([4.8, 1.9, 1.7]),
        changes_lane=False,
        deviation=np.zeros(2),
        ground_z=0.0,
        attitude=np.zeros(2),
    )
    car = Actors(
        id=np.array([1]),
        name=np.array(["car"]),
        kind=np.array([Kind.CAR], dtype=np.uint8),
        pose_world=np.array([[8.0 + 0.5 * index, 2.0, 0.5]]),
        velocity_world=np.array([[6.0, 0.0]]),
        acceleration_world=np.zeros((1, 2)),
        yaw_rate=np.zeros(1),
        articulation=np.zeros(1),
        mode=np.zeros(1, np.uint8),
        changes_lane=np.zeros(1, np.bool_),
        deviation=np.zeros((1, 2)),
        ground_z=np.zeros(1),
        attitude=np.full((1, 2), 0.01),  # a level body is not tilted
        size=np.array([[4.5, 1.8, 1.5]]),
        reflectivity=np.array([0.5]),
    )
    return WorldFrame(index, 0.08 * index, ego, car)
