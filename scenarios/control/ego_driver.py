"""Closed-loop drives of the ego: on the tracks, and on the ground truth."""

from luxloop.scenarios.control.control_config import CruiseConfig
from luxloop.scenarios.control.cruise import CruiseController, Decision
from luxloop.scenarios.control.safety import SafetyLog
from luxloop.scenarios.control.surroundings import TrackedSurroundings, true_surroundings
from luxloop.sim.source import EgoCommand, TrafficSource
from luxloop.sim.world import WorldFrame
from luxloop.tracker.records import Tracks
from luxloop.tracker.scan import Scan


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
