"""The controller at the wheel: by the tracks, and beside that by the truth."""

from scenarios.control.control_config import CruiseConfig
from scenarios.control.cruise import Cruise, Decision
from scenarios.control.safety import SafetyLog
from scenarios.control.surroundings import TrackEye, truth_around
from sim.source import EgoCommand, TrafficSource
from sim.world import WorldFrame
from tracker.records import Tracks
from tracker.scan import Scan


class TrackDriver:
    """Drives the ego by what the tracker sees.

    Parameters
    ----------
    config
        Of the controller.
    source
        Takes its commands.
    """

    def __init__(self, config: CruiseConfig, source: TrafficSource):
        self._source = source
        self._eye = TrackEye(source.dt)
        self._cruise = Cruise(config, source.dt)
        self.log = SafetyLog()

    def drive(self, frame: WorldFrame, scan: Scan, tracks: Tracks) -> Decision | None:
        """Command the ego for the next frame; at the first scan there is nothing to go by. The truth is only logged."""
        around = self._eye.look(frame.ego, scan, tracks)
        decision = self._cruise.decide(around) if around else None
        if decision:
            self._source.apply(EgoCommand(speed_mps=decision.speed_mps))
        self.log.add(frame, decision.speed_mps if decision else None)
        return decision


def drive_by_truth(config: CruiseConfig, source: TrafficSource, log: SafetyLog, frames: int) -> None:
    """Drive a source that was reset for as many frames by the truth, without sensor and tracker."""
    cruise = Cruise(config, source.dt)
    for _ in range(frames):
        frame = source.step()
        decision = cruise.decide(truth_around(frame))
        source.apply(EgoCommand(speed_mps=decision.speed_mps))
        log.add(frame, decision.speed_mps)
