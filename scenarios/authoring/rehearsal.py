"""Rehearsal of a draft: its traffic alone, without sensor and tracker."""

from contextlib import closing
from dataclasses import dataclass

import numpy as np

from luxloop.scenarios.authoring.ego_survey import sensor_range
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.run import progress
from luxloop.sim.factory import make_source
from luxloop.sim.source import TrafficEndedError, watch_start
from luxloop.sim.world import VEHICLE_KINDS, WorldFrame

_KINDS = np.array(sorted(VEHICLE_KINDS))


@dataclass(frozen=True, slots=True)
class Rehearsal:
    """Course of the traffic of a draft."""

    frames: int
    """Frames until the end."""
    duration_s: float
    """[s] Their duration, rounded down to 0.1 s."""
    near: float
    """Mean number of vehicles within the range of grading."""
    end: str
    """Reason why it ended early; empty if it did not."""

    @property
    def complete(self) -> bool:
        """True if it lasted for the duration of the draft."""
        return not self.end


def rehearse(scenario: Scenario) -> Rehearsal:
    """Play the traffic of a scenario once.

    Raises
    ------
    TrafficError
        The traffic cannot start, or fails.
    """
    near, end = [], ""
    with closing(make_source(scenario.traffic, scenario.folder, sensor_range(scenario.rig, scenario.folder))) as source:
        with progress.start("rehearsal") as report:
            watch_start(source, report)
            source.reset(scenario.seed)
        count = max(1, round(scenario.duration_s / source.dt))
        try:
            for _ in progress.frames(count, source.dt, "rehearsal"):
                near.append(_near(source.step(), scenario.grading.range_max_m))
        except TrafficEndedError as error:
            end = str(error)
        seconds = len(near) * source.dt
    return Rehearsal(len(near), np.floor(10 * seconds + 1e-6) / 10, float(np.mean(near)) if near else 0.0, end)


def _near(frame: WorldFrame, range_m: float) -> int:
    offset = frame.actors.pose_world[:, :2] - frame.ego.pose_world[:2]
    near = np.hypot(*offset.T) <= range_m
    return int((near & np.isin(frame.actors.kind, _KINDS)).sum())
