"""Reported ranges and echo pulse widths: noise, outliers, quantisation and limits."""

from dataclasses import dataclass

import numpy as np

from luxloop.arrays import Bools, Floats, Ints
from luxloop.sensor_model.noise.noise_config import NoiseConfig
from luxloop.sensor_model.noise.outliers import gross_error
from luxloop.sensor_model.noise.random_draws import Draws
from luxloop.sensor_model.noise.range_error import range_error, width_error
from luxloop.sensor_model.rig.beams import BeamTable

_PLACE_M = 0.5  # below the shipped units' echo separation; echoes within the same cell share their error


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredRanges:
    """Reported ranges of N echoes."""

    range: Floats
    """(N,) [m]."""
    outlier: Bools
    """(N,) True if the range has a gross error."""


def echo_places(true_range: Floats) -> Ints:
    """Return (N,) keys that distinguish the echoes of a beam: half-metre cells of the leading edges (N,) [m].

    An echo's number in the beam is not used, so that it keeps its errors if rain or a loss in front of it changes the
    numbers.
    """
    return (true_range / _PLACE_M).astype(np.int64)


def measure_ranges(
    beam: Ints, true_range: Floats, place: Ints, real: Bools, beams: BeamTable, config: NoiseConfig, draws: Draws,
    frame: int,
) -> MeasuredRanges:  # fmt: skip
    """Return the ranges that the units report, with independent draws per echo.

    Reported ranges stay within the limits of the unit. They are multiples of the quantum if range noise is enabled.

    Parameters
    ----------
    beam, true_range
        (N,) rows of the beam table, and ranges of the leading edges [m].
    place
        (N,) `echo_places`.
    real
        (N,) True for echoes of surfaces; only these have gross errors.
    """
    range_, outlier = true_range, np.zeros(len(beam), dtype=np.bool_)
    if config.range.enabled:
        range_ = range_ + range_error(config.range, beam, true_range, place, beams, draws, frame)
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
    return MeasuredRanges(range=range_, outlier=outlier)


def measure_widths(
    beam: Ints, place: Ints, width: Floats, beams: BeamTable, config: NoiseConfig, draws: Draws, frame: int
) -> Floats:
    """Return the (N,) echo pulse widths that the units report [m]: at least one quantum, and multiples of it.

    Parameters
    ----------
    beam, place, width
        (N,) rows of the beam table, `echo_places`, and widths without error [m].
    """
    if config.range.enabled:
        width = width + width_error(beam, place, beams, draws, frame)
    quantum = beams.units.pulse_quantum.take(beams.unit.take(beam))
    reported: Floats = np.maximum(np.rint(width / quantum), 1.0) * quantum
    return reported
