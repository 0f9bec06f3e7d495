"""Constants of simulator and grader, and those of the tracker: measured or chosen independently.

A number that both sides took from each other would hide an error: the tracker would fit the simulation, not the world.
Each row names one quantity, its value on both sides, and the sources.
"""

import math
from pathlib import Path

import pytest

from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.sensor_model.noise.calibration import CalibrationError
from luxloop.sensor_model.rig.rig import load_rig
from luxloop.sensor_model.visibility import MAX_CLEAN_DEPTH
from luxloop.sim.modes import ModeLimits
from luxloop.sim.scripted.script import EGO_SIZE, SIZE_BY_KIND
from luxloop.sim.world import Kind
from luxloop.tracker.detection.boxes import DEPTH_STD_M, NOISE_STD_M
from luxloop.tracker.detection.faces import CURVE_DEPTH_M
from luxloop.tracker.detection.heading_posterior import SHAPE_STD_RAD
from luxloop.tracker.detection.lidar import LidarConfig
from luxloop.tracker.detection.preprocess import PreprocessConfig
from luxloop.tracker.tracking.existence import ExistenceConfig, existence
from luxloop.tracker.tracking.filters import STARTING_SPEED_STD_MPS, FilterConfig
from luxloop.tracker.tracking.mma import STANDING_MPS
from luxloop.tracker.vehicle_classes import SIZE_CLASSES

UNIT = load_rig("srx_six_lux", Path()).mounts[0].model
MODES, FILTERS = ModeLimits(), FilterConfig()
CAR, _, LORRY, _, MOTORCYCLE = SIZE_CLASSES

TUNED = {
    "range noise [m]": (
        (UNIT.range_sigma_m, "unit file, with its source"),
        (LidarConfig().range_std_m, "a third of two steps of the data sheet's distance resolution"),
    ),
    "scatter about a side [m]": (
        (UNIT.range_sigma_m, "unit file, with its source"),
        (NOISE_STD_M, "scan lines on real cars"),
    ),
    "depth of a point on a face [m]": (
        (MAX_CLEAN_DEPTH, "setback and relief of the simulated hoods, inside the outline"),
        (CURVE_DEPTH_M, "bow of real fronts and rears at hood height"),
    ),
    "limit of standing [m/s]": (
        (MODES.stands_below_mps, MODES.moves_from_mps, "a third of walking pace, with hysteresis"),
        (STANDING_MPS, "1 km/h"),
    ),
    "speed at the start of a motion [m/s]": (
        (MODES.moves_from_mps, "a third of walking pace"),
        (STARTING_SPEED_STD_MPS, "gained in five scans at a comfortable acceleration"),
    ),
    "acceleration of a steady course [m/s^2]": (
        (MODES.steady_below_mps2, MODES.accelerates_from_mps2, "0.1 m off the course in 0.6 s"),
        (FILTERS.acceleration_std_mps2, "unnoticed oscillation of following drivers"),
    ),
    "direction of a face by one unit [rad]": (
        (math.radians(CalibrationError().yaw_sigma_deg), "residual error of a calibrated mount"),
        (SHAPE_STD_RAD, "bow of real flanks and ends"),
    ),
    "position of a face [m]": (
        (CalibrationError().xy_sigma_m, "residual error of a calibrated mount"),
        (DEPTH_STD_M, FILTERS.position_std_floor_m, "layers of real cars, beam spacing"),
    ),
    "length of a car [m]": (
        (SIZE_BY_KIND[Kind.CAR][0], "a mid-size sedan"),
        (CAR.length.low_m, "between nuScenes and KITTI"),
    ),
    "length of a truck [m]": (
        (SIZE_BY_KIND[Kind.TRUCK][0], "a box truck"),
        (LORRY.length.low_m, "shorter ones are vans"),
    ),
    "width of a truck [m]": ((SIZE_BY_KIND[Kind.TRUCK][1], "legal limit"), (LORRY.width.low_m, "nuScenes")),
    "length of a motorcycle [m]": (
        (SIZE_BY_KIND[Kind.MOTORCYCLE][0], "SUMO's default"), (MOTORCYCLE.length.low_m, "nuScenes"),
    ),
    "width of a motorcycle [m]": ((SIZE_BY_KIND[Kind.MOTORCYCLE][1], "estimate"), (MOTORCYCLE.width.low_m, "nuScenes")),
}  # fmt: skip
"""Quantity: (values, source) of simulator or grader, (values, source) of the tracker."""

FACTS = {
    "the ego's body, from its data sheet [m]": (
        EGO_SIZE[:2], (PreprocessConfig().own_length_m, PreprocessConfig().own_width_m),
    ),
}  # fmt: skip
"""Known properties of the own car and units, which both sides read off the same data sheet."""


@pytest.mark.parametrize("quantity", TUNED)
def test_no_tuned_constant_is_shared(quantity):
    (*simulated, source), (*tracked, own_source) = TUNED[quantity]
    assert not set(simulated) & set(tracked), quantity
    assert source != own_source
    middle = sum(simulated) / len(simulated)
    assert all(value != pytest.approx(middle) for value in tracked), "not the middle of the simulator's limits either"


@pytest.mark.parametrize("fact", FACTS)
def test_facts_of_the_own_car_agree(fact):
    simulated, tracked = FACTS[fact]
    assert simulated == pytest.approx(tracked)


def test_the_requirement_on_memory_is_the_graders():
    """The grader follows an occluded vehicle for the 3 s that scenarios require; the tracker's memory is longer."""
    memory = ExistenceConfig()
    assert existence(GradingConfig().memory_s, 1.0, memory) > memory.existence_min
