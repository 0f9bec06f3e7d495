"""Precipitation: what rain and snow have in common."""

import math

from luxloop import elementwise
from luxloop.arrays import Ints
from luxloop.sensor_model.kernels.noise import rare_beams
from luxloop.sensor_model.noise.clutter_mixing import Clutter, droplets, unit_beams
from luxloop.sensor_model.noise.random_draws import Draws, Purpose
from luxloop.sensor_model.noise.thresholds import Thresholds
from luxloop.sensor_model.rig.beams import BeamTable
from luxloop.sensor_model.truth import Cause

_DB_PER_NEPER = 10.0 / math.log(10.0)  # of power
_M_PER_KM = 1000.0


def per_metre(db_per_km: float) -> float:
    """Convert an attenuation of power [dB/km] to an extinction coefficient [1/m]."""
    return float(db_per_km / (_DB_PER_NEPER * _M_PER_KM))


def falling_echoes(
    rate: float, log_range: tuple[float, float], cause: Cause, labelled: float,
    purposes: tuple[Purpose, Purpose, Purpose], beams: BeamTable, thresholds: Thresholds, draws: Draws, frame: int,
) -> Clutter:  # fmt: skip
    """Draw the echoes of drops or flakes in a frame; their ranges are lognormal.

    Parameters
    ----------
    rate
        Share of the beams with an echo, in a clean and working unit.
    log_range
        Mean and standard deviation of the natural logarithm of the range in metres.
    labelled
        Share of the echoes that the unit flags as clutter.
    purposes
        Purposes of the draws of beams, ranges, and labels with powers.
    """
    beam: Ints = rare_beams(draws.key, frame, int(purposes[0]), unit_beams(beams), rate)
    range_ = elementwise.exp(log_range[0] + log_range[1] * draws.normal(frame, beam, purposes[1]))
    return droplets(beam, range_, cause, labelled, draws.uniform(frame, beam, purposes[2]), beams, thresholds)
