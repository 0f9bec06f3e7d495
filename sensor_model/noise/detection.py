"""The power that every beam needs to give an echo, and why a beam gave none."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from sensor_model.beams import BeamTable
from sensor_model.draws import Draws
from sensor_model.noise.config import NoiseConfig
from sensor_model.noise.dirt import window_transmission
from sensor_model.noise.dropout import Sensitivity
from sensor_model.noise.outage import Outages
from sensor_model.noise.sun import Glare
from sensor_model.noise.thresholds import Thresholds
from sensor_model.truth import Loss

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]
Losses = npt.NDArray[np.uint8]


class Detection:
    """The detectors of one run.

    Parameters
    ----------
    unit_names
        (U) names of the units in the rig, to which outages and dirt refer.

    Raises
    ------
    ValueError
        An outage or a dirty sector names a unit that the rig does not have.
    """

    def __init__(self, config: NoiseConfig, beams: BeamTable, draws: Draws, unit_names: Sequence[str]) -> None:
        self._config = config
        self._beams = beams
        self._sensitivity = Sensitivity(config.dropout, beams, draws)
        self._passed = window_transmission(config.dirt, beams, unit_names)
        self._dirty = self._passed < 1.0
        self._outages = Outages(config.outage, draws, unit_names)
        self._glare = Glare(config.sun, beams)
        self._hard = beams.units.threshold[beams.unit]
        self._no_reason = np.full(len(beams), Loss.THRESHOLD, dtype=np.uint8)
        self._turn, self._turns = beams.fan_turn[_fan(beams)].T
        self._all_fire = np.ones(len(beams), dtype=np.bool_) if np.all(self._turns == 1) else None

    def thresholds(self, frame: int, time: float, ego_yaw_world: float) -> Thresholds:
        """What every beam needs in a frame.

        Parameters
        ----------
        frame, time
            Index, and time since the start of the run [s].
        ego_yaw_world
            Heading of the ego, for the sun [rad].
        """
        config, own, threshold, reason = self._config, self._hard, self._hard, self._no_reason
        if config.dropout.enabled:
            own, lost = self._sensitivity.threshold(frame)
            threshold, reason = own.copy(), reason.copy()
        if config.sun.enabled:
            sunlit = self._glare.sunlit(ego_yaw_world)
            threshold = np.where(sunlit, threshold / config.sun.gain, threshold)
            reason = np.where(sunlit, np.uint8(Loss.SUN), reason)
        if config.dirt.enabled:
            with np.errstate(divide="ignore"):  # nothing passes: infinite
                threshold = threshold / self._passed
            reason = np.where(self._dirty, np.uint8(Loss.DIRT), reason)
        if config.dropout.enabled:
            threshold[lost], reason[lost] = np.inf, Loss.RANDOM
        firing = self._firing(frame)
        if config.outage.enabled:
            silent = self._outages.silent(time)[self._beams.unit]
            threshold = np.where(silent, np.inf, threshold)
            reason = np.where(silent, np.uint8(Loss.OUTAGE), reason)
            firing = firing & ~silent
        return Thresholds(threshold=threshold, own=own, reason=reason, firing=firing)

    def _firing(self, frame: int) -> Bools:
        """(B,) whether the beam's mirror face is the one of this frame."""
        if self._all_fire is not None:
            return self._all_fire
        firing: Bools = frame % self._turns == self._turn
        return firing


def why_lost(thresholds: Thresholds, beam: Ints, peak_power: Floats, dry_power: Floats) -> Losses:
    """Say why beams that met something gave no echo.

    The unit's own threshold comes first: an echo too weak for a clean, shaded, working unit in dry air is lost to it,
    whatever else was in the way. Then comes what alone would have hidden it (outage, chance, dirt, sun), then rain.

    Parameters
    ----------
    beam
        (L,) rows of the beam table.
    peak_power, dry_power
        (L,) highest power that came back, and what it would have been without rain [1/m^2].

    Returns
    -------
    (L,) `Loss`
    """
    threshold, own = thresholds.threshold[beam], thresholds.own[beam]
    loss = np.where(dry_power >= threshold, np.uint8(Loss.RAIN), thresholds.reason[beam])
    weak = np.maximum(peak_power, dry_power) < own
    return np.where(weak, np.uint8(Loss.THRESHOLD), loss)


def _fan(beams: BeamTable) -> Ints:
    """(B,) fan of each beam."""
    beams_of_fan = np.diff(beams.row_beam[beams.fan_row])
    return np.repeat(np.arange(len(beams_of_fan)), beams_of_fan)
