"""The shipped rig, and inputs of the noise models."""

from functools import cache
from pathlib import Path

import numpy as np

from luxloop.sensor_model.noise.detection import DetectionThresholds
from luxloop.sensor_model.noise.noise_config import Dropout, NoiseConfig
from luxloop.sensor_model.noise.random_draws import Draws
from luxloop.sensor_model.returns import Returns
from luxloop.sensor_model.rig.beams import beam_table
from luxloop.sensor_model.rig.rig import load_rig
from luxloop.sensor_model.scan_context import ScanContext

RIG = load_rig("srx_six_lux", Path())
BEAMS = beam_table(RIG)
NAMES = [mount.name for mount in RIG.mounts]
ALL = np.arange(len(BEAMS))
HARD = Dropout(enabled=False)


def thresholds(config=None, frame=0, time=0.0, ego_yaw=0.0, seed=1, beams=BEAMS, names=NAMES):
    """Return the thresholds of a frame; hard ones by default."""
    config = config or NoiseConfig(dropout=HARD)
    return DetectionThresholds(config, beams, Draws(seed, beams), names).thresholds(frame, time, ego_yaw)


@cache
def healthy():
    """Return the thresholds of the rig without faults, computed once."""
    return thresholds()


def context(beams=BEAMS, **changes):
    """Return the context of an ego at standstill with nominal mounts in dry air."""
    values = {
        "frame_index": 0,
        "origin_ego": beams.units.origin_ego,
        "R_ego_unit": beams.units.R_ego_unit,
        "time_jitter": np.zeros(len(beams.units)),
        "ego_velocity": np.zeros(2),
        "ego_acceleration": np.zeros(2),
        "ego_yaw_rate": 0.0,
        "threshold": np.full(len(beams), 4e-5),
    }
    return ScanContext(**(values | changes))


def returns(beam, range_, width=0.5):
    """Return returns from surfaces; each has its index as its target."""
    count = len(beam)
    return Returns(
        beam=np.asarray(beam, dtype=np.int64),
        range=np.asarray(range_, dtype=np.float64),
        width=np.full(count, width),
        power=np.full(count, 1e-3),
        target=np.arange(count),
        surface=np.arange(count),
        part=np.full(count, 3, dtype=np.uint8),
        cause=np.zeros(count, dtype=np.uint8),
        point_body=np.ones((count, 2)),
        flags=np.zeros(count, dtype=np.uint16),
    )


def within(count, trials, share, sigmas=4.5):
    """Return True if a binomial count is within so many standard deviations of its mean."""
    return abs(count - trials * share) <= sigmas * np.sqrt(trials * share * (1 - share)) + 1e-9
