"""Adaptive cruise control by the Intelligent Driver Model.

Treiber, Hennecke and Helbing, "Congested traffic states in empirical observations and microscopic simulations",
Physical Review E 62 (2000) 1805.
"""

import math
from dataclasses import dataclass

from scenarios.control.control_config import CruiseConfig
from scenarios.control.corridor import Lead, lead_of
from scenarios.control.surroundings import Surroundings

_EXPONENT = 4
"""delta of the model: how late the acceleration fades towards the set speed."""
_LEAST_GAP = 0.1
"""[m] The model divides by the gap."""
_AHEAD_OF_ITSELF = 3.0
"""[m/s] How far the wanted speed runs ahead where the vehicle does not follow, as at a speed limit."""


@dataclass(frozen=True, slots=True)
class Decision:
    """What the controller made of one look."""

    speed_mps: float
    """[m/s] wanted at the next frame."""
    lead: Lead | None
    """For whom."""


def idm_acceleration(speed: float, lead: Lead | None, config: CruiseConfig) -> float:
    """Acceleration [m/s^2] by equations (2) and (3) of the paper, held within the largest deceleration.

    a [1 - (v/v0)^4 - (s*/s)^2] with s* = s0 + max(0, v T + v (v - v_lead) / (2 sqrt(a b))).
    """
    a, b = config.acceleration_mps2, config.comfortable_deceleration_mps2
    usage = (speed / config.set_speed_mps) ** _EXPONENT
    if lead is not None:
        dynamic = speed * config.time_gap_s + speed * (speed - lead.speed) / (2.0 * math.sqrt(a * b))
        usage += ((config.standstill_gap_m + max(0.0, dynamic)) / max(lead.gap, _LEAST_GAP)) ** 2
    return max(a * (1.0 - usage), -config.max_deceleration_mps2)


class Cruise:
    """Integrates the model's acceleration to the speed that the vehicle is told to drive.

    Parameters
    ----------
    config
        What it wants and may do.
    dt
        Time between decisions [s].
    """

    def __init__(self, config: CruiseConfig, dt: float):
        self._config = config
        self._dt = dt
        self._wanted: float | None = None

    def decide(self, around: Surroundings) -> Decision:
        """Take the next look and decide."""
        lead = lead_of(around, self._config.corridor_half_width_m)
        speed = max(around.speed, 0.0)
        before = speed if self._wanted is None else self._wanted
        wanted = before + idm_acceleration(speed, lead, self._config) * self._dt
        self._wanted = min(max(wanted, 0.0), speed + _AHEAD_OF_ITSELF)
        return Decision(self._wanted, lead)
