"""Simulated twins: labelled cars as bodies of the ray caster, seen by the recorded sensor."""

from dataclasses import replace

import numpy as np
from twin.labels import Car, View
from twin.recording import RecordedFrame
from twin.unit import rig_of

from luxloop.arrays import Floats, Ints
from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.noise.noise_config import KINDS, NoiseConfig
from luxloop.sensor_model.sensor_config import SensorConfig
from luxloop.sim.world import Actors, Ego, Kind, Obstacles, WorldFrame

KIND_OF = {
    "small car": Kind.CAR,
    "sedan": Kind.CAR,
    "SUV": Kind.SUV,
    "van": Kind.VAN,
    "truck": Kind.TRUCK,
    "pickup": Kind.SUV,
}
"""A sport utility vehicle of a pickup's length has the body of one."""
PAINT = 0.07
"""Reflectivity of a car whose sensor does not measure it: about the median of the others."""
PANEL_SPREAD_DB = 11.0
"""[dB] Spread of the returned power over one car's panels, from 10 to 90 %: five cars whose returns are well
above the threshold have 9 to 13. The noise model's soft threshold represents it: a body has one per part."""
NOISE = ("range", "dropout", "mirror", "layer_overlap")
SENSOR = SensorConfig(footprint=(3, 3), sweep=False)


def twin_scan(frame: RecordedFrame, view: View, car: Car, cars: list[Car], seed: int) -> tuple[Floats, Ints]:
    """Simulate the sensor of a frame over a labelled car, among all `cars` of that frame.

    Returns
    -------
    points_level
        (N, 3) in the level frame of the recording [m].
    layer
        (N,) ring, counted upwards.
    """
    noise = NoiseConfig()
    noise = replace(noise, **{kind: replace(getattr(noise, kind), enabled=kind in NOISE) for kind in KINDS})
    noise = replace(noise, dropout=replace(noise.dropout, softness_db=PANEL_SPREAD_DB))
    lidar = Lidar(rig_of(frame, view, car), noise, SENSOR, seed, Obstacles.from_polygons([], []))
    scan, _ = lidar.scan(_world(cars))
    return scan.points_ego.astype(np.float64) + np.array([0.0, 0.0, car.z_ground_m]), scan.layer.astype(np.int64)


def _world(cars: list[Car]) -> WorldFrame:
    count = len(cars)
    still = np.zeros((count, 2))
    actors = Actors(
        id=np.arange(count, dtype=np.int64),
        name=np.array([car.id for car in cars], dtype=np.str_),
        kind=np.array([KIND_OF[car.category] for car in cars], dtype=np.uint8),
        pose_world=np.array([car.box[:3] for car in cars]),
        velocity_world=still,
        acceleration_world=still,
        yaw_rate=np.zeros(count),
        articulation=np.zeros(count),
        mode=np.zeros(count, np.uint8),
        changes_lane=np.zeros(count, np.bool_),
        deviation=still,
        ground_z=np.zeros(count),
        attitude=still,
        size=np.array([(car.length_m, car.width_m, car.height_m) for car in cars]),
        reflectivity=np.array([PAINT if np.isnan(car.reflectivity) else car.reflectivity for car in cars]),
    )
    ego = Ego(
        np.zeros(3), np.zeros(2), np.zeros(2), 0.0, np.array([4.8, 1.9, 1.7]), False, np.zeros(2), 0.0, np.zeros(2)
    )
    return WorldFrame(0, 0.0, ego, actors)
