"""Units that fall silent for a while, as when their packets are missing."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from sensor_model.arrays import Bools
from sensor_model.kernels import noise as kernels
from sensor_model.noise.random_draws import Draws, Purpose
from sensor_model.rig.unit_names import rows_of

TICK_S = 0.02
"""[s] Step of the chain: the scan of a LUX at its highest rate, 50 Hz. Outages are the same at every scan rate."""

_ROUNDING = 1e-6  # of a tick


@dataclass(frozen=True, slots=True)
class FixedOutage:
    """A unit that is silent for a known time."""

    unit: str
    """Name of the unit in the rig file, or * for all."""
    from_s: float
    """[s] since the start of the run."""
    to_s: float
    """[s] since the start of the run; the unit is back in a frame at this time."""

    def __post_init__(self) -> None:
        if not self.from_s < self.to_s:
            raise ValueError(f"to_s = {self.to_s}: must be after from_s = {self.from_s}")


@dataclass(frozen=True, slots=True)
class Outage:
    """Whole units that are silent: a two-state chain for each (Gilbert 1960, Elliott 1963), and at known times."""

    enabled: bool = False
    """If not, no unit is ever silent."""
    mean_uptime_s: float = 120.0
    """[s] Mean time from the end of an outage to the next one; an estimate. 1e9 leaves the fixed ones only."""
    mean_outage_s: float = 2.0
    """[s] Mean length of an outage; an estimate."""
    fixed: tuple[FixedOutage, ...] = ()
    """Outages at known times, for scenarios that are about them."""

    def __post_init__(self) -> None:
        if not 0.0 < self.mean_uptime_s < math.inf:
            raise ValueError(f"mean_uptime_s = {self.mean_uptime_s}: must be positive; 1e9 for none but the fixed ones")
        if not 0.0 < self.mean_outage_s < math.inf:
            raise ValueError(f"mean_outage_s = {self.mean_outage_s}: must be positive and finite; use fixed for longer")


def transitions(config: Outage) -> tuple[float, float]:
    """Probabilities that a unit fails, and that a silent one recovers, in a tick.

    Those of the two-state process in continuous time with the rates a = 1 / mean_uptime_s and b = 1 / mean_outage_s
    after TICK_S: a / (a + b) (1 - exp(-(a + b) TICK_S)), and the same with b.
    """
    a, b = 1.0 / config.mean_uptime_s, 1.0 / config.mean_outage_s
    mixed = -math.expm1(-(a + b) * TICK_S) / (a + b)
    return a * mixed, b * mixed


class Outages:
    """Which units are silent when.

    Raises
    ------
    ValueError
        A fixed outage names a unit that the rig does not have.
    """

    def __init__(self, config: Outage, draws: Draws, unit_names: Sequence[str]) -> None:
        self._draws = draws
        self._units = len(unit_names)
        self._transitions = transitions(config)
        self._fixed = [(rows_of(each.unit, unit_names), each.from_s, each.to_s) for each in config.fixed]

    def silent(self, time: float) -> Bools:
        """(U,) whether each unit is silent at a time since the start of the run [s]."""
        tick = math.floor(time / TICK_S + _ROUNDING)
        silent: Bools = kernels.silent_units(
            self._draws.key, tick, int(Purpose.OUTAGE), self._units, *self._transitions
        )
        for rows, start, end in self._fixed:
            silent[rows] |= start <= time < end
        return silent
