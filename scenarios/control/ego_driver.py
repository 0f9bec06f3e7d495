"""Closed-loop drives of the ego: on the tracks, and on the ground truth.

The speed is that of the Intelligent Driver Model: Treiber, Hennecke and Helbing,
"Congested traffic states in empirical observations and microscopic simulations",
Physical Review E 62 (2000) 1805.
"""

import math
from dataclasses import dataclass

from luxloop.scenarios.control.control_config import CruiseConfig
from luxloop.scenarios.control.safety import SafetyLog
from luxloop.scenarios.control.surroundings import (
    LeadVehicle,
    Surroundings,
    TrackedSurroundings,
    find_lead,
    true_surroundings,
)
from luxloop.sim.source import EgoCommand, TrafficSource
from luxloop.sim.world import WorldFrame
from luxloop.tracker.records import Tracks
from luxloop.tracker.scan import Scan

_EXPONENT = 4
"""delta of the model: exponent of the acceleration's decrease towards the set speed."""
_MIN_GAP = 0.1
"""[m] Lower bound of the gap, by which the model divides."""
_MAX_EXCESS = 3.0
"""[m/s] Anti-windup: maximum excess of the commanded over the actual speed, e.g. at a speed limit."""


@dataclass(frozen=True, slots=True)
class Decision:
    """Output of the controller for one frame."""

    speed_mps: float
    """[m/s] Commanded speed at the next frame."""
    lead: LeadVehicle | None
    """Lead vehicle, if any."""


def idm_acceleration(speed: float, lead: LeadVehicle | None, config: CruiseConfig) -> float:
    """Return the acceleration [m/s^2] by equations (2) and (3) of the paper, limited to the maximum deceleration.

    a [1 - (v/v0)^4 - (s*/s)^2] with s* = s0 + max(0, v T + v (v - v_lead) / (2 sqrt(a b))).
    """
    a, b = config.acceleration_mps2, config.comfortable_deceleration_mps2
    usage = (speed / config.set_speed_mps) ** _EXPONENT
    if lead is not None:
        dynamic = speed * config.time_gap_s + speed * (speed - lead.speed) / (2.0 * math.sqrt(a * b))
        usage += ((config.standstill_gap_m + max(0.0, dynamic)) / max(lead.gap, _MIN_GAP)) ** 2
    return max(a * (1.0 - usage), -config.max_deceleration_mps2)


class CruiseController:
    """Integrates the model's acceleration to the commanded speed.

    Parameters
    ----------
    config
        Parameters of the controller.
    dt
        Time between decisions [s].
    """

    def __init__(self, config: CruiseConfig, dt: float):
        self._config = config
        self._dt = dt
        self._commanded: float | None = None

    def decide(self, around: Surroundings) -> Decision:
        """Return the command for the next frame."""
        lead = find_lead(around, self._config.corridor_half_width_m)
        speed = max(around.speed, 0.0)
        before = speed if self._commanded is None else self._commanded
        commanded = before + idm_acceleration(speed, lead, self._config) * self._dt
        self._commanded = min(max(commanded, 0.0), speed + _MAX_EXCESS)
        return Decision(self._commanded, lead)


class TrackDriver:
    """Drives the ego on the confirmed tracks.

    Parameters
    ----------
    config
        Parameters of the controller.
    source
        Traffic source that executes the commands.
    """

    def __init__(self, config: CruiseConfig, source: TrafficSource):
        self._source = source
        self._surroundings = TrackedSurroundings(source.dt)
        self._controller = CruiseController(config, source.dt)
        self.log = SafetyLog()

    def drive(self, frame: WorldFrame, scan: Scan, tracks: Tracks) -> Decision | None:
        """Command the ego for the next frame; None at the first scan, before the speed is known.

        The ground truth `frame` is only logged, except for the size of the ego.
        """
        around = self._surroundings.observe(frame.ego, scan, tracks)
        decision = self._controller.decide(around) if around else None
        if decision:
            self._source.apply(EgoCommand(speed_mps=decision.speed_mps))
        self.log.add(frame, decision.speed_mps if decision else None)
        return decision


def drive_by_truth(config: CruiseConfig, source: TrafficSource, log: SafetyLog, frames: int) -> None:
    """Drive a freshly reset source for a number of frames on the ground truth, without sensor and tracker."""
    controller = CruiseController(config, source.dt)
    for _ in range(frames):
        frame = source.step()
        decision = controller.decide(true_surroundings(frame))
        source.apply(EgoCommand(speed_mps=decision.speed_mps))
        log.add(frame, decision.speed_mps)
