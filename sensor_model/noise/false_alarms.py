"""False alarms of the detector, and of its flag for clutter."""

from dataclasses import dataclass

import numpy as np

from luxloop.arrays import Bools, Ints
from luxloop.sensor_model.kernels.noise import rare_beams
from luxloop.sensor_model.noise.clutter_mixing import Clutter, unit_beams, weak_clutter
from luxloop.sensor_model.noise.random_draws import Draws, Purpose
from luxloop.sensor_model.noise.thresholds import Thresholds
from luxloop.sensor_model.rig.beams import BeamTable
from luxloop.sensor_model.truth import Cause, Part


@dataclass(frozen=True, slots=True)
class FalseAlarms:
    """Points without an object, from detector noise or light of other units, and wrong flags."""

    enabled: bool = True
    """If false, the detector responds to echoes only, and flags none but droplets as clutter."""
    rate: float = 1e-4
    """Share of the beams with a false alarm in a scan; an estimate; 1e-5 to 1e-4 is plausible. The six units of the
    shipped rig have half a false alarm per scan."""
    flagged: float = 0.005
    """Share of the echoes of surfaces, ghosts and false alarms that the unit flags as clutter; an estimate. None of the
    139 points of a recorded scan has the flag, so that at most 0.02 is plausible."""

    def __post_init__(self) -> None:
        if not 0.0 < self.rate <= 1.0:
            raise ValueError(f"rate = {self.rate}: must be above 0 and at most 1; use enabled = false for none")
        if not 0.0 <= self.flagged <= 1.0:
            raise ValueError(f"flagged = {self.flagged}: must be from 0 to 1")


def false_alarms(config: FalseAlarms, beams: BeamTable, thresholds: Thresholds, draws: Draws, frame: int) -> Clutter:
    """Draw the false alarms of a frame, uniform over the unit's range."""
    beam: Ints = rare_beams(draws.key, frame, int(Purpose.FALSE_ALARM), unit_beams(beams), config.rate)
    unit = beams.unit[beam]
    nearest, farthest = beams.units.range_min[unit], beams.units.range_max[unit]
    range_ = nearest + (farthest - nearest) * draws.uniform(frame, beam, Purpose.FALSE_ALARM_RANGE)[0]
    unlabelled = np.zeros(len(beam), dtype=np.bool_)
    chance = draws.uniform(frame, beam, Purpose.FALSE_ALARM_POWER)[0]
    return weak_clutter(beam, range_, chance, Part.NONE, Cause.FALSE_ALARM, unlabelled, beams, thresholds)


def wrong_flags(config: FalseAlarms, beam: Ints, place: Ints, draws: Draws, frame: int) -> Bools:
    """Return the (N,) mask of echoes that the unit would flag as clutter by mistake, by a draw per echo.

    `place` (N,) distinguishes the echoes of a beam.
    """
    if not config.enabled:
        return np.zeros(len(beam), dtype=np.bool_)
    flagged: Bools = draws.uniform(frame, beam, Purpose.CLUTTER_FLAG, place)[0] < config.flagged
    return flagged
