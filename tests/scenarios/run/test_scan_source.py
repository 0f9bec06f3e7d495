"""Traffic and LIDARs in a process of their own, ahead of the tracker: the same results and errors as in one process."""

import os

import pandas as pd
import pytest
from support import short_run
from support.processes import children_of, is_dead

from luxloop.scenarios.errors import ScenarioError
from luxloop.scenarios.files import shipped
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.run import device, loop
from luxloop.sim.process.process_source import _terminate_idle
from luxloop.tracker.tracker import Tracker

CROSSING = shipped.CATALOG / "urban" / "sumo-crossing"
ARRIVING = f"""
description = "The ego starts a few metres before the end of its only edge."
duration_s = 60
[traffic]
kind = "sumo"
net = "{CROSSING / "crossing.net.xml"}"
routes = ["ego.rou.xml"]
"""
EGO = '<vehicle id="ego" depart="0" departPos="-3" departSpeed="10"><route edges="north_out"/></vehicle>'


def both(path, duration_s=0.8):
    """Return the results of a scenario in one process and ahead."""
    scenario = Scenario.load(path, {"duration_s": duration_s})
    return [loop.run(scenario, device.load(device.SHIPPED), ahead=ahead) for ahead in (False, True)]


@pytest.mark.parametrize("name", ["sumo-crossing", "merge-generic-v0", "cruise-on-tracks"])
def test_a_run_ahead_has_the_same_results(name):
    """SUMO, highway-env, and a controlled ego, whose commands depend on the tracks."""
    one, other = both(shipped.find(name))
    assert one.frames == 10
    for field in ("trace_hash", "frames", "ended_early", "config", "warnings"):
        assert getattr(one, field) == getattr(other, field), field
    assert one.metrics.keys() == other.metrics.keys()
    timed = {name for name in one.metrics if name.startswith("perf.")}
    assert all(one.metrics[name] == other.metrics[name] for name in one.metrics.keys() - timed)
    assert all(one.metrics[name].n == other.metrics[name].n for name in timed)
    for table, rows in one.tables.items():
        pd.testing.assert_frame_equal(rows, other.tables[table])


def test_traffic_that_ends_early_ends_the_run_with_the_same_message(tmp_path):
    (tmp_path / "ego.rou.xml").write_text(f"<routes>{EGO}</routes>")
    one, other = both(short_run.write(tmp_path, ARRIVING), 60.0)
    assert one.ended_early.startswith('ego "ego" left the net at ')
    assert 0 < one.frames == other.frames
    assert (one.ended_early, one.simulator_failed) == (other.ended_early, other.simulator_failed)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (ARRIVING, "traffic: .*ego.rou.xml"),
        (short_run.TEXT + '[noise.outage]\nfixed = [{ unit = "roof", from_s = 0.0, to_s = 1.0 }]\n', "noise: .*roof"),
    ],
)
def test_errors_at_the_start_are_the_same(text, message, tmp_path):
    """A route file that does not exist, and noise of a unit that the rig does not have."""
    scenario, lines = Scenario.load(short_run.write(tmp_path, text)), []
    for ahead in (False, True):
        with pytest.raises(ScenarioError, match=message) as error:
            loop.run(scenario, device.load(device.SHIPPED), ahead=ahead)
        lines.append(str(error.value))
    assert lines[0] == lines[1]


@pytest.mark.parametrize("ahead", [False, True])
def test_only_a_run_ahead_has_a_process_of_its_own_which_ends(ahead, tmp_path):
    """Scripted traffic needs none. The process is kept for the next run, until the idle ones are ended."""
    _terminate_idle()
    before, found = set(children_of(os.getpid())), set()

    def tracker(config):
        found.update(set(children_of(os.getpid())) - before)
        return Tracker(config)

    loop.run(Scenario.load(short_run.write(tmp_path)), tracker, ahead=ahead)
    assert len(found) == ahead
    _terminate_idle()
    assert all(map(is_dead, found))
