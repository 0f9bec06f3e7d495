"""The range that a unit reports for an echo."""

from dataclasses import dataclass

import numpy as np

from sensor_model.arrays import Bools, Floats, Ints
from sensor_model.noise.noise_config import NoiseConfig
from sensor_model.noise.outliers import gross_error
from sensor_model.noise.random_draws import Draws
from sensor_model.noise.range_error import range_error
from sensor_model.rig.beams import BeamTable

_PLACE_M = 0.5  # less than the shipped units' echo separation; echoes that are nearer may share their error


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """What N echoes are reported as."""

    range: Floats
    """(N,) [m]."""
    outlier: Bools
    """(N,) grossly wrong."""


def measured(
    beam: Ints, true_range: Floats, real: Bools, beams: BeamTable, config: NoiseConfig, draws: Draws, frame: int
) -> Measured:
    """Measure echoes, each with draws of its own.

    The echoes of a beam are told apart by the half metre that they are in, not by their number: so an echo keeps its
    error when rain or a loss before it changes the numbers.

    Errors never take a range out of the limits of its unit. Ranges are whole quanta where range noise is enabled.

    Parameters
    ----------
    beam, true_range
        (N,) rows of the beam table, and ranges of the leading edges [m].
    real
        (N,) whether the echo is a surface's: gross errors are told of these alone.
    """
    place = (true_range / _PLACE_M).astype(np.int64)
    range_, outlier = true_range, np.zeros(len(beam), dtype=np.bool_)
    if config.range.enabled:
        range_ = range_ + range_error(config.range, beam, place, beams, draws, frame)
    if config.outliers.enabled:
        error, drawn = gross_error(config.outliers, beam, place, draws, frame)
        outlier = drawn & real
        range_ = range_ + np.where(outlier, error, 0.0)
    unit = beams.unit.take(beam)
    if config.range.enabled:
        quantum = beams.units.range_quantum.take(unit)
        range_ = np.rint(range_ / quantum) * quantum
    if config.range.enabled or config.outliers.enabled:
        range_ = np.minimum(np.maximum(range_, beams.units.range_min.take(unit)), beams.units.range_max.take(unit))
    return Measured(range=range_, outlier=outlier)
