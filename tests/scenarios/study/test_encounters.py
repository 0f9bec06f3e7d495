"""Scenes of encounters: the target is hidden, emerges, and is at the meeting point together with the ego.

The emergence of a target behind a parked truck is repeated by hand, frame by frame from the tables of real runs.
"""

import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from support.emergence_by_hand import emergence
from support.few import few

from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.metrics.definitions import MEASURES, STAGES
from luxloop.scenarios.run import device, loop
from luxloop.scenarios.study import staged

SCENES = {
    "car": (staged.behind_parked_truck, (8.0, 4.0, "car")),
    "child": (staged.behind_parked_truck, (14.0, 2.0, "child")),
    "house": (staged.past_house, (14.0, 5.0)),
    "bus": (staged.behind_turning_bus, (6.0, 8.0)),
    "lorry": (staged.cut_in_past_lorry, (28.0, 16.0, "lorry")),
    "coach": (staged.cut_in_past_lorry, (20.0, 16.0, "coach")),
}
POINTS_IN_GAPS = 9
"""Most points on a hidden target: single beams pass below a truck or through the windows of a bus."""


@cache
def result(name):
    scene, values = SCENES[name]
    document = scene(*values) | {"seed": 11}
    return loop.run(Scenario.of(document, Path("scene.toml")), device.load(device.SHIPPED))


def target(name):
    truth = result(name).tables["truth"]
    return truth[truth["name"] == "target"]


@pytest.mark.parametrize("name", few(["car", "child", "house", "bus", "coach"], "car", "child"))
def test_the_target_is_hidden_at_first_and_in_view_at_the_end(name):
    rows = target(name)
    assert rows["points"].head(20).max() <= POINTS_IN_GAPS
    assert rows["hits_alone"].head(20).min() > 0
    assert rows["points"].iloc[-6:-3].min() >= 10


@pytest.mark.slow
def test_low_lidars_see_a_car_below_a_lorry_and_not_below_a_coach():
    assert target("lorry")["points"].head(20).max() > 0
    assert target("coach")["points"].head(20).max() == 0


@pytest.mark.parametrize("name", few(SCENES, "car", "child"))
def test_the_ego_s_front_is_at_the_meeting_point_at_the_end_of_the_approach(name):
    # Jitter moves the target by up to 0.25 m, and the meeting point with it.
    at_start = result(name).tables["emergence"]
    first = at_start[(at_start["name"] == "target") & (at_start["stage"] == "first_beam")].iloc[0]
    approach_s = 0.08 * result(name).frames - 0.24
    speed = SCENES[name][1][0]
    slack_m = {"bus": 0.5, "lorry": 1.5, "coach": 1.5}.get(name, 0.25)  # oblique paths
    assert first["time_s"] + first["meeting_s"] == pytest.approx(approach_s, abs=slack_m / speed + 0.08)


@pytest.mark.parametrize("name", few(SCENES, "car", "child"))
def test_ego_and_target_touch_at_the_end_and_not_before(name):
    """A miss would make the time to the meeting point meaningless."""
    tables = result(name).tables
    ego, other = tables["ego"], target(name)
    distance = np.hypot(*(ego[f"{axis}_world_m"].to_numpy() - other[f"{axis}_world_m"].to_numpy() for axis in "xy"))
    assert distance.argmin() >= len(ego) - 5
    assert distance.min() < 4.9  # less than both half lengths together


@pytest.mark.parametrize("name", ["car", "child"])
def test_emergence_equals_the_computation_by_hand(name):
    run = result(name)
    by_hand = emergence(run.tables)
    assert list(by_hand) == list(STAGES)
    for stage, values in by_hand.items():
        metric = {name: run.metrics[f"emergence.{name}{{stage={stage}}}"] for name in MEASURES}
        assert metric["reached"].value == float(values is not None), stage
        for measure, value in (values or {}).items():
            tolerance = {"meeting_m": 0.02, "meeting_s": 0.003, "ttc_s": 0.002}.get(measure, 1e-9)
            found = metric[measure].value
            assert (math.inf if found is None else found) == pytest.approx(value, abs=tolerance), (stage, measure)


def test_a_child_is_seen_and_a_car_is_confirmed():
    assert result("child").metrics["emergence.reached{stage=enough_points,group=person}"].value == 1.0
    assert result("car").metrics["emergence.reached{stage=confirmed}"].value == 1.0


@pytest.mark.parametrize(
    ("stage", "message"),
    [
        (lambda: staged.behind_parked_truck(0.0, 2.0), "ego_mps = 0"),
        (lambda: staged.behind_parked_truck(8.0, 2.0, "dog"), 'who = "dog"'),
        (lambda: staged.past_house(8.0, -1.0), "target_mps = -1"),
        (lambda: staged.behind_turning_bus(-4.0, 8.0), "ego_mps = -4"),
        (lambda: staged.cut_in_past_lorry(10.0, 12.0), "should be more than target_mps = 12"),
        (lambda: staged.cut_in_past_lorry(10.0, 1.0), "too slow to change lanes"),
        (lambda: staged.cut_in_past_lorry(20.0, 16.0, "tram"), 'occluder = "tram"'),
    ],
)
def test_invalid_parameters_raise_a_value_error(stage, message):
    with pytest.raises(ValueError, match=message):
        stage()
