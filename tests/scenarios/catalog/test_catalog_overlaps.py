"""No two bodies of the shipped SUMO traffic overlap. The traffic is played without sensor."""

from contextlib import closing, suppress

import pytest
from support.few import few

from luxloop.scenarios.control.ego_driver import drive_by_truth
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.files.shipped import paths
from luxloop.scenarios.grading.truth_events.bodies import Bodies, body_name, overlaps
from luxloop.sim.source import TrafficEndedError
from luxloop.sim.sumo.sumo_config import SumoTraffic
from luxloop.sim.sumo.sumo_source import SumoSource

OVERLAP_MAX_M2 = 0.1
RANGE_M = 200.0
SLOW_SEEDS = range(1, 11)
NAMES = [name for name, path in paths().items() if isinstance(Scenario.load(path).traffic, SumoTraffic)]


class OverlapLog:
    """Largest overlap [m^2] by the names of both bodies."""

    def __init__(self):
        self.frames = 0
        self.largest = {}

    def add(self, frame, _wanted_mps=None):
        """Note the overlaps of a frame. The second argument is that of `SafetyLog.add`."""
        self.frames += 1
        for first, second, area in zip(*overlaps(Bodies.of(frame)), strict=True):
            pair = body_name(frame, first), body_name(frame, second)
            self.largest[pair] = max(self.largest.get(pair, 0.0), float(area))


def overlapping(name, seed):
    """Return the pairs that overlap by more than `OVERLAP_MAX_M2`, with the largest overlap [m^2] of each."""
    scenario, log = Scenario.load(paths()[name]), OverlapLog()
    source = SumoSource(scenario.traffic, scenario.folder, RANGE_M)
    count = round(scenario.duration_s / source.dt)
    with closing(source), suppress(TrafficEndedError):
        source.reset(seed)
        if scenario.traffic.ego_control:
            drive_by_truth(scenario.control, source, log, count)
        else:
            for _ in range(count):
                log.add(source.step())
    assert log.frames > 0.8 * count  # an ego may leave the net shortly before the end
    return {pair: area for pair, area in log.largest.items() if area > OVERLAP_MAX_M2}


# Each fails for one seed if its cause comes back: sliding in queues (crossings, cut-in) and left turns after the phase,
# instant lane changes, a parking place on a lane, and people whose steps aside take seconds.
OVERLAPPED = {
    "sumo-crossing": 2, "left-hand-crossing": 7, "sumo-cut-in": 9, "cruise-on-tracks": 6, "paper-campus": 1,
    "crosswalk": 2,
}  # fmt: skip


@pytest.mark.parametrize(("name", "seed"), few(OVERLAPPED.items(), "crosswalk"))
def test_no_bodies_overlap_where_they_did(name, seed):
    assert overlapping(name, seed) == {}


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_no_bodies_of_a_shipped_scenario_overlap(name):
    assert {seed: found for seed in SLOW_SEEDS if (found := overlapping(name, seed))} == {}
