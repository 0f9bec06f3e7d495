"""Temporary outages of units, such as missing packets."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from luxloop import elementary
from luxloop.arrays import Bools
from luxloop.sensor_model.kernels import noise as kernels
from luxloop.sensor_model.noise.random_draws import Draws, Purpose
from luxloop.sensor_model.rig.unit_names import unit_rows

TICK_S = 0.02
"""[s] Step of the Markov chain at any scan rate: a scan of the LUX at its highest rate, 50 Hz."""

_ROUNDING = 1e-6  # of a tick


@dataclass(frozen=True, slots=True)
class FixedOutage:
    """Outage of a unit in a fixed interval."""

    unit: str
    """Name of the unit in the rig file, or * for all units."""
    from_s: float
    """[s] Start of the outage, since the start of the run."""
    to_s: float
    """[s] End of the outage, since the start of the run; the unit works again in a frame at this time."""

    def __post_init__(self) -> None:
        if not self.from_s < self.to_s:
            raise ValueError(f"to_s = {self.to_s}: must be after from_s = {self.from_s}")


@dataclass(frozen=True, slots=True)
class Outage:
    """Outages of whole units: a two-state Markov chain per unit (Gilbert 1960, Elliott 1963), and fixed intervals."""

    enabled: bool = False
    """If false, all units work all the time."""
    mean_uptime_s: float = 120.0
    """[s] Mean time from the end of an outage to the next one; an estimate. 1e9 leaves only the fixed outages."""
    mean_outage_s: float = 2.0
    """[s] Mean length of an outage; an estimate."""
    fixed: tuple[FixedOutage, ...] = ()
    """Outages in fixed intervals."""

    def __post_init__(self) -> None:
        if not 0.0 < self.mean_uptime_s < math.inf:
            raise ValueError(f"mean_uptime_s = {self.mean_uptime_s}: must be positive; use 1e9 for fixed outages only")
        if not 0.0 < self.mean_outage_s < math.inf:
            raise ValueError(
                f"mean_outage_s = {self.mean_outage_s}: must be positive and finite; use fixed for longer outages"
            )


def transitions(config: Outage) -> tuple[float, float]:
    """Return the probabilities that a unit fails, and that a silent one recovers, in a tick.

    They are those of the two-state process in continuous time, with the rates a = 1 / mean_uptime_s and
    b = 1 / mean_outage_s, after TICK_S: a / (a + b) (1 - exp(-(a + b) TICK_S)), and the same with b.
    """
    a, b = 1.0 / config.mean_uptime_s, 1.0 / config.mean_outage_s
    mixed = -elementary.expm1(-(a + b) * TICK_S) / (a + b)
    return a * mixed, b * mixed


class Outages:
    """Outages of one run.

    Raises
    ------
    ValueError
        A fixed outage names a unit that the rig does not have.
    """

    def __init__(self, config: Outage, draws: Draws, unit_names: Sequence[str]) -> None:
        self._draws = draws
        self._units = len(unit_names)
        self._transitions = transitions(config)
        self._fixed = [(unit_rows(each.unit, unit_names), each.from_s, each.to_s) for each in config.fixed]

    def silent(self, time: float) -> Bools:
        """Return the (U,) mask of the silent units at a time since the start of the run [s]."""
        tick = math.floor(time / TICK_S + _ROUNDING)
        silent: Bools = kernels.silent_units(
            self._draws.key, tick, int(Purpose.OUTAGE), self._units, *self._transitions
        )
        for rows, start, end in self._fixed:
            silent[rows] |= start <= time < end
        return silent
