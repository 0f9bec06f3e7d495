"""The power that every beam needs to give an echo, and why a beam gave none."""

from collections.abc import Sequence

import numpy as np

from sensor_model.arrays import Bools, Bytes, Floats, Ints
from sensor_model.noise.dirt import window_transmission
from sensor_model.noise.dropout import Sensitivity
from sensor_model.noise.noise_config import NoiseConfig
from sensor_model.noise.outage import Outages
from sensor_model.noise.random_draws import Draws
from sensor_model.noise.sun import Glare
from sensor_model.noise.thresholds import Thresholds
from sensor_model.rig.beams import BeamTable
from sensor_model.truth import Loss


class DetectionThresholds:
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
        self._outages = Outages(config.outage, draws, unit_names)
        self._glare = Glare(config.sun, beams)
        self._hard = beams.units.threshold[beams.unit]
        self._shade = np.ones(len(beams))
        self._none_blind = np.full(len(beams), Loss.THRESHOLD, dtype=np.uint8)
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
        config, own, gain, blind, firing = self._config, self._hard, self._shade, self._none_blind, self._firing(frame)
        if config.dropout.enabled:
            own, lost = self._sensitivity.threshold(frame)
            blind = np.where(lost, np.uint8(Loss.RANDOM), blind)
        if config.sun.enabled:
            gain = np.where(self._glare.sunlit(ego_yaw_world), config.sun.gain, self._shade)
        if config.outage.enabled:
            silent = self._outages.silent(time)[self._beams.unit]
            blind = np.where(silent, np.uint8(Loss.OUTAGE), blind)
            firing = firing & ~silent
        with np.errstate(divide="ignore"):  # nothing passes: infinite
            needed = own / (gain * self._passed)
        return Thresholds(
            threshold=np.where(blind == Loss.THRESHOLD, needed, np.inf),
            own=own,
            gain=gain,
            passed=self._passed,
            blind=blind,
            firing=firing,
        )

    def _firing(self, frame: int) -> Bools:
        """(B,) whether the beam's mirror face is the one of this frame."""
        if self._all_fire is not None:
            return self._all_fire
        firing: Bools = frame % self._turns == self._turn
        return firing


def why_lost(thresholds: Thresholds, beam: Ints, peak_power: Floats, dry_power: Floats) -> Bytes:
    """Say why beams that met something gave no echo.

    The unit's own threshold comes first: an echo too weak for a clean, shaded, working unit in dry air is lost to it,
    whatever else was in the way. Then comes what alone is the reason, so that without it there would have been an echo:
    outage, chance, rain, dirt, sun. Where dirt and sun had to come together, the one that takes more is named.

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
    own, blind = thresholds.own[beam], thresholds.blind[beam]
    gain, passed = thresholds.gain[beam], thresholds.passed[beam]
    with np.errstate(divide="ignore"):  # nothing passes: infinite
        in_shade = peak_power >= own / passed
    cleaned = peak_power >= own / gain
    loss = np.where(cleaned | (~in_shade & (passed <= gain)), np.uint8(Loss.DIRT), np.uint8(Loss.SUN))
    loss = np.where(dry_power >= thresholds.threshold[beam], np.uint8(Loss.RAIN), loss)
    loss = np.where(blind != Loss.THRESHOLD, blind, loss)
    return np.where(dry_power < own, np.uint8(Loss.THRESHOLD), loss)


def _fan(beams: BeamTable) -> Ints:
    """(B,) fan of each beam."""
    beams_of_fan = np.diff(beams.row_beam[beams.fan_row])
    return np.repeat(np.arange(len(beams_of_fan)), beams_of_fan)
