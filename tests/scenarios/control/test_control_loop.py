"""Closed loop with traffic simulator, LIDARs and tracker: the ego brakes for the reported tracks."""

import numpy as np
import pytest
from support import short_run
from support.frames import tracks_of

from luxloop.scenarios.control.ego_driver import NO_CONTROL, drive_by_truth
from luxloop.scenarios.errors import ScenarioError
from luxloop.scenarios.files import shipped
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.metrics.definitions import DEFINITIONS
from luxloop.scenarios.run import device, loop
from luxloop.sim.source import SimulatorFailedError

CRUISE = shipped.CATALOG / "highway" / "cruise-on-tracks.toml"


def drive(duration_s, factory=None):
    scenario = Scenario.load(CRUISE, {"duration_s": duration_s})
    return loop.run(scenario, factory or device.load(device.SHIPPED))


CONTROLLED = [name for name in DEFINITIONS if name.startswith("control.")]


def speeds(result, driver):
    table = result.tables["control"]
    return table.loc[table["driver"] == driver, "speed_mps"].to_numpy()


@pytest.mark.slow
def test_the_closed_loop_is_deterministic():
    once, again = drive(4.0), drive(4.0)
    assert once.trace_hash == again.trace_hash
    for name in CONTROLLED:
        assert once.metrics[name] == again.metrics[name]
    assert once.tables["control"].equals(again.tables["control"])


class Blind:
    """Reports no tracks."""

    def __init__(self, config):
        del config

    def step(self, scan):
        del scan
        return tracks_of([])


def test_without_tracks_the_ego_collides_and_on_the_truth_it_does_not():
    """If the truth drove in both drives, both would stop."""
    result = drive(11.6, Blind)
    value = {name: metric.value for name, metric in result.metrics.items()}
    assert value["control.collisions"] == 1
    assert value["control.min_ttc_s"] < 0.2
    assert value["control.truth_collisions"] == 0
    assert value["control.truth_min_ttc_s"] > 1.5
    assert speeds(result, "tracks")[-1] > 14.0
    assert speeds(result, "truth")[-1] < 5.0


def test_on_the_tracks_the_ego_brakes_as_on_the_truth_and_not_earlier():
    result = drive(10.0)
    by_tracks, by_truth = speeds(result, "tracks"), speeds(result, "truth")
    assert len(by_tracks) == len(by_truth) == result.frames == 125
    assert by_tracks[-1] < 7.5
    np.testing.assert_allclose(by_tracks, by_truth, atol=1.5)
    # the lead vehicle brakes: the filters react in the same frame at the earliest
    assert np.argmax(by_tracks < 13.5) >= np.argmax(by_truth < 13.5) > 80


def test_a_simulator_failure_in_the_drive_on_the_truth_keeps_the_drive_on_the_tracks(monkeypatch):
    def fail_in_its_third_frame(config, source, log, frames):
        drive_by_truth(config, source, log, min(frames, 2))
        raise SimulatorFailedError("SUMO gave up")

    monkeypatch.setattr(loop, "drive_by_truth", fail_in_its_third_frame)
    result = drive(0.8)
    assert (result.frames, result.complete, result.simulator_failed) == (10, False, True)
    assert result.ended_early == "SUMO gave up"
    assert result.metrics["control.collisions"].n == 10
    assert result.metrics["control.truth_collisions"].n == 2


def test_without_control_there_is_no_second_drive():
    result = short_run.result()
    assert "control" not in result.tables
    assert {result.metrics[name].reason for name in CONTROLLED} == {NO_CONTROL}


SUMO = 'description = "x"\nduration_s = 1\ntraffic = { kind = "sumo", net = "n", routes = ["r"] }\n'


@pytest.mark.parametrize("text", [short_run.TEXT, SUMO])
def test_control_of_an_uncontrollable_ego_is_a_one_line_error(tmp_path, text):
    path = short_run.write(tmp_path, text + '\n[control]\nkind = "cruise"\nset_speed_mps = 20.0\n')
    with pytest.raises(
        ScenarioError, match=r"short\.toml: control: the ego cannot be controlled.*ego_control"
    ) as error:
        Scenario.load(path)
    assert "\n" not in str(error.value)


def test_an_unknown_key_of_the_controller_is_named(tmp_path):
    text = CRUISE.read_text(encoding="utf-8").replace("set_speed_mps = 16.6", "set_speed = 16.6")
    with pytest.raises(ScenarioError, match=r"control\.set_speed = 16\.6: unknown key; did you mean set_speed_mps"):
        Scenario.load(short_run.write(tmp_path, text))
