"""Detection thresholds of the beams, and causes of lost beams."""

from collections.abc import Sequence

import numpy as np

from luxloop.arrays import Bools, Bytes, Floats, Ints
from luxloop.sensor_model.noise.dirt import window_transmission
from luxloop.sensor_model.noise.dropout import Sensitivity
from luxloop.sensor_model.noise.noise_config import NoiseConfig
from luxloop.sensor_model.noise.outage import Outages
from luxloop.sensor_model.noise.random_draws import Draws
from luxloop.sensor_model.noise.sun import Glare
from luxloop.sensor_model.noise.thresholds import Thresholds
from luxloop.sensor_model.rig.beams import BeamTable
from luxloop.sensor_model.truth import Loss


class DetectionThresholds:
    """Detection thresholds of one run.

    Parameters
    ----------
    unit_names
        (U,) names of the units in the rig, referred to by outages and dirt.

    Raises
    ------
    ValueError
        An outage or a dirty sector names a unit that the rig does not have.
    """

    def __init__(self, config: NoiseConfig, beams: BeamTable, draws: Draws, unit_names: Sequence[str]) -> None:
        self._config = config
        self._beams = beams
        self._sensitivity = Sensitivity(config.dropout, beams, draws)
        self._transmission = window_transmission(config.dirt, beams, unit_names)
        self._outages = Outages(config.outage, draws, unit_names)
        self._glare = Glare(config.sun, beams)
        self._hard = beams.units.threshold[beams.unit]
        self._shade = np.ones(len(beams))
        self._none_blind = np.full(len(beams), Loss.THRESHOLD, dtype=np.uint8)
        self._turn, self._turns = beams.fan_turn[_fan(beams)].T
        self._all_fire = np.ones(len(beams), dtype=np.bool_) if np.all(self._turns == 1) else None

    def thresholds(self, frame: int, time: float, ego_yaw_world: float) -> Thresholds:
        """Return the detection thresholds of all beams in a frame.

        Parameters
        ----------
        frame, time
            Index of the frame, and time since the start of the run [s].
        ego_yaw_world
            Heading of the ego, for the sun [rad].
        """
        config, nominal, gain, blind, firing = (
            self._config,
            self._hard,
            self._shade,
            self._none_blind,
            self._firing(frame),
        )
        if config.dropout.enabled:
            nominal, lost = self._sensitivity.threshold(frame)
            blind = np.where(lost, np.uint8(Loss.RANDOM), blind)
        if config.sun.enabled:
            gain = np.where(self._glare.sunlit(ego_yaw_world), config.sun.gain, self._shade)
        if config.outage.enabled:
            silent = self._outages.silent(time)[self._beams.unit]
            blind = np.where(silent, np.uint8(Loss.OUTAGE), blind)
            firing = firing & ~silent
        with np.errstate(divide="ignore"):  # zero transmission: infinite threshold
            needed = nominal / (gain * self._transmission)
        return Thresholds(
            threshold=np.where(blind == Loss.THRESHOLD, needed, np.inf),
            nominal=nominal,
            gain=gain,
            transmission=self._transmission,
            blind=blind,
            firing=firing,
        )

    def _firing(self, frame: int) -> Bools:
        """Return the (B,) mask of beams whose mirror face is active in this frame."""
        if self._all_fire is not None:
            return self._all_fire
        firing: Bools = frame % self._turns == self._turn
        return firing


def loss_causes(thresholds: Thresholds, beam: Ints, peak_power: Floats, dry_power: Floats) -> Bytes:
    """Return the causes of beams that hit something and gave no echo.

    The nominal threshold has priority: an echo too weak for a clean, shaded, working unit in dry air is lost to it.
    Otherwise the cause is the effect without which there would have been an echo, in this order: outage, random loss,
    rain, snow or fog, dirt, sun. If only dirt and sun together suppress the echo, the stronger of them is the cause.

    Parameters
    ----------
    beam
        (L,) rows of the beam table.
    peak_power, dry_power
        (L,) highest power returned, and the same in clear air [1/m^2].

    Returns
    -------
    (L,) `Loss`
    """
    nominal, blind = thresholds.nominal.take(beam), thresholds.blind.take(beam)
    gain, transmission = thresholds.gain.take(beam), thresholds.transmission.take(beam)
    with np.errstate(divide="ignore"):  # zero transmission: infinite threshold
        in_shade = peak_power >= nominal / transmission
    cleaned = peak_power >= nominal / gain
    loss = np.where(cleaned | (~in_shade & (transmission <= gain)), np.uint8(Loss.DIRT), np.uint8(Loss.SUN))
    loss = np.where(dry_power >= thresholds.threshold.take(beam), np.uint8(Loss.AIR), loss)
    loss = np.where(blind != Loss.THRESHOLD, blind, loss)
    return np.where(dry_power < nominal, np.uint8(Loss.THRESHOLD), loss)


def _fan(beams: BeamTable) -> Ints:
    """Return the (B,) fan of each beam."""
    beams_of_fan = np.diff(beams.row_beam[beams.fan_row])
    return np.repeat(np.arange(len(beams_of_fan)), beams_of_fan)
