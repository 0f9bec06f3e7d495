"""Unit model of a recorded Ouster sensor: rings and columns of its metadata, sensitivity as the frames show it."""

from typing import NamedTuple

import numpy as np
from twin.labels import Car, View
from twin.recording import RecordedFrame

from luxloop.sensor_model.rig.rig import Mount, Rig
from luxloop.sensor_model.rig.unit import Fan, UnitModel


class Sensor(NamedTuple):
    """Figures of a sensor that its metadata does not have."""

    divergence_deg: float
    """Full width of a beam at half its power (data sheets of the maker)."""
    far_m: float
    """Range at which 10 % is the weakest reflectivity."""
    weakest_near: float
    near_field_m: float = 0.0
    """Nearer than this the sensitivity falls too steeply for one threshold per car."""


SENSORS = {
    "OS-0-128": Sensor(0.35, 31.0, 0.001),
    "OS-1-128": Sensor(0.18, 70.0, 0.003),
    "OS-1-32": Sensor(0.18, 60.0, 0.004),
    "OS-2-128": Sensor(0.09, 68.0, 0.02, 10.0),
    "OS-2-32": Sensor(0.09, 68.0, 0.02, 10.0),
}
"""By the lowest percent of the reported reflectivities of a whole frame, by range: it grows with the square of the
range far away. Near, reflectivity per signal and square range grows (four-fold for the OS-1-32 at 7 m, ten- to
twenty-fold for the OS-2 at 7 to 10 m): the optics collect less from near, and the weakest reflectivity stays.
The OS-2-32 has no calibrated reflectivity; its figures are those of the OS-2-128."""
RANGE_SIGMA_M = 0.015
"""Range noise of a strong echo (data sheet of the OS1)."""
_NEAR_SIDE_M = 1.5
"""[m] The visible sides of a car are about this much nearer than its centre."""


def sensor_of(car: Car) -> Sensor:
    """Return the sensor of a car's recording, whose name begins with that of the sensor."""
    return next(sensor for name, sensor in SENSORS.items() if car.recording.startswith(name))


def in_near_field(car: Car) -> bool:
    """Return whether a car is too near for the sensor's law of sensitivity."""
    return car.range_m < sensor_of(car).near_field_m


def rig_of(frame: RecordedFrame, view: View, car: Car) -> Rig:
    """Return the rig of one unit, at the sensor's attitude and its height over the ground at the car.

    The caster's ground is flat; the ground of a street is not, so each car has its own rig.
    """
    height = view.height_m - car.z_ground_m
    return Rig(0.0, (Mount("roof", unit_of(frame, car), 0.0, 0.0, height, 0.0, view.pitch_deg, view.roll_deg),))


def unit_of(frame: RecordedFrame, car: Car) -> UnitModel:
    """Return the unit model, with the sensitivity at the range of a car; layer 0 is the lowest ring.

    It reports one echo per beam, the nearest.
    """
    nearest = max(car.range_m - _NEAR_SIDE_M, _NEAR_SIDE_M)
    order = np.argsort(frame.elevation_deg, kind="stable")
    step = 360.0 / frame.columns
    first = (180.0 - np.mod(frame.azimuth_deg[order], step)).tolist()
    sensor, none = sensor_of(car), (0.0,) * len(order)
    weakest = max(sensor.weakest_near, 0.1 * (nearest / sensor.far_m) ** 2)
    return UnitModel(
        scan_rate_hz=10.0, range_min_m=0.5, range_max_m=200.0,
        beam_width_deg=sensor.divergence_deg, beam_height_deg=sensor.divergence_deg,
        reference_reflectivity=weakest, reference_range_m=nearest,
        pulse_length_m=0.675, pulse_growth_m_per_db=0.0, pulse_quantum_m=0.01, pulse_sigma_m=0.0,
        echoes_max=1, echo_separation_m=1.0,
        range_sigma_m=RANGE_SIGMA_M, range_sigma_far_m=RANGE_SIGMA_M, range_quantum_m=0.001,
        layer_elevation_deg=tuple(frame.elevation_deg[order].tolist()), layer_bias_m=none, layer_pulse_bias_m=none,
        gain_azimuth_deg=(0.0,), turns=1,
        fans=tuple(Fan((n,), at, at - (frame.columns - 1) * step, step, (100.0,)) for n, at in enumerate(first)),
    )  # fmt: skip
