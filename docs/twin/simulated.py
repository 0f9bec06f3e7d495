"""Simulated twins: labelled cars as bodies of the ray caster, seen by the recorded sensor."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from twin.labels import Car, View
from twin.recording import RecordedFrame
from twin.unit import rig_of

from luxloop.arrays import Floats, Ints
from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.noise.noise_config import KINDS, NoiseConfig
from luxloop.sensor_model.sensor_config import SensorConfig
from luxloop.sim.scripted.script import KindName, ScriptedActor
from luxloop.sim.scripted.scripted_source import ScriptedSource, ScriptedTraffic

KINDS_OF: dict[str, KindName] = {"SUV": "suv", "van": "van", "truck": "truck", "pickup": "suv"}
"""Kinds of bodies; other classes are cars. A sport utility vehicle of a pickup's length has the body of one."""
PAINT = 0.07
"""Reflectivity of a car whose sensor does not measure it: about the median of the others."""
PANEL_SPREAD_DB = 11.0
"""[dB] Spread of the returned power over one car's panels, from 10 to 90 %: five cars whose returns are well
above the threshold have 9 to 13. The noise model's soft threshold represents it: a body has one per part."""
NOISE = ("range", "dropout", "mirror", "layer_overlap")
SENSOR = SensorConfig(footprint=(3, 3), sweep=False)


def twin_scan(frame: RecordedFrame, view: View, car: Car, cars: list[Car], seed: int) -> tuple[Floats, Ints]:
    """Return the points of a frame's sensor over a labelled car, among all `cars` of that frame, and their layers.

    Points (N, 3) are in the level frame of the recording [m]; layers (N,) are rings, counted upwards.
    """
    noise = NoiseConfig()
    noise = replace(noise, **{kind: replace(getattr(noise, kind), enabled=kind in NOISE) for kind in KINDS})
    noise = replace(noise, dropout=replace(noise.dropout, softness_db=PANEL_SPREAD_DB))
    source = _source(cars)
    lidar = Lidar(rig_of(frame, view, car), noise, SENSOR, seed, source.reset(seed))
    scan, _ = lidar.scan(source.step())
    return scan.points_ego.astype(np.float64) + np.array([0.0, 0.0, car.z_ground_m]), scan.layer.astype(np.int64)


def _source(cars: list[Car]) -> ScriptedSource:
    actors = []
    for car in cars:
        paint = PAINT if np.isnan(car.reflectivity) else car.reflectivity
        pose = {"x_m": car.x_m, "y_m": car.y_m, "yaw_deg": car.heading_deg}
        size, kind = (car.length_m, car.width_m, car.height_m), KINDS_OF.get(car.category, "car")
        actors.append(ScriptedActor(**pose, kind=kind, size_m=size, reflectivity=paint, name=car.id))
    return ScriptedSource(ScriptedTraffic(actor=actors, jitter_m=0.0, jitter_deg=0.0), Path(), range_m=200.0)
