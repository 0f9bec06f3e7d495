"""Highway scenarios: the described events happen in the traffic, without sensor and tracker."""

from contextlib import closing
from functools import cache

import numpy as np
import pandas as pd
import pytest

from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.files.shipped import CATALOG
from luxloop.sim.highway.highway_config import HighwayTraffic
from luxloop.sim.highway.highway_source import HighwaySource
from luxloop.sim.sumo.sumo_config import SumoTraffic
from luxloop.sim.sumo.sumo_source import SumoSource

FAMILY = sorted((CATALOG / "highway").glob("*.toml"))
SOURCES = {SumoTraffic: SumoSource, HighwayTraffic: HighwaySource}
GRADED_M = 50.0
LANE_M = 3.75
"""[m] Lane width of the SUMO motorway; highway-env's lanes are 4 m wide."""


@cache
def drive(name):
    """Return a row for each actor in each frame: its position in the ego frame, and both vehicles' motions."""
    scenario = Scenario.load(CATALOG / "highway" / f"{name}.toml")
    rows = []
    with closing(SOURCES[type(scenario.traffic)](scenario.traffic, scenario.folder, 200.0)) as source:
        source.reset(scenario.seed)
        for _ in range(round(scenario.duration_s / source.dt)):
            frame = source.step()
            rows.append(seen_from_ego(frame))
    return pd.concat(rows, ignore_index=True)


def seen_from_ego(frame):
    ego, actors = frame.ego, frame.actors
    heading = np.array([np.cos(ego.pose_world[2]), np.sin(ego.pose_world[2])])
    offset = actors.pose_world[:, :2] - ego.pose_world[:2]
    return pd.DataFrame(
        {
            "time": frame.time,
            "name": actors.name,
            "ahead": offset @ heading,
            "left": offset @ np.array([-heading[1], heading[0]]),
            "speed": np.hypot(*actors.velocity_world.T),
            "y_world": actors.pose_world[:, 1],
            "ego_y_world": ego.pose_world[1],
            "ego_speed": np.hypot(*ego.velocity_world),
            "ego_braking": -(ego.acceleration_world @ heading),
        }
    )


def of(name, actor):
    """Return the rows of one actor in the graded range, by time."""
    table = drive(name)
    rows = table[(table["name"] == actor) & (np.hypot(table["ahead"], table["left"]) < GRADED_M)]
    assert len(rows) > 0, f"{actor} never enters the graded range"
    return rows.set_index("time")


def time_abreast(rows):
    """Return the time [s] at which an actor is first abreast of the ego."""
    sign = np.sign(rows["ahead"])
    return rows.index[sign != sign.iloc[0]][0]


def test_the_family_contains_enough_scenarios_of_both_simulators():
    kinds = [Scenario.load(path).traffic.kind for path in FAMILY]
    assert len(kinds) >= 8
    assert kinds.count("highway-env") >= 3


@pytest.mark.parametrize("path", FAMILY, ids=lambda path: path.stem)
def test_every_expectation_has_a_unit_and_a_need(path):
    limits = Scenario.load(path).expect
    assert [name for name, limit in limits.items() if not (limit.unit and limit.need)] == []


def test_on_a_free_motorway_vehicles_pass_or_fall_behind_in_their_lanes():
    for actor, lane in {"motorbike": 1, "first_fast": 1, "second_fast": 1, "semitrailer": -1, "lorry": -1}.items():
        rows = of("free-flow", actor)
        closing_mps = (rows["speed"] - rows["ego_speed"]).mean()
        assert lane * closing_mps > 11.0
        assert lane * rows["ahead"].iloc[0] < -40.0
        assert lane * rows["ahead"].iloc[-1] > 20.0
        assert rows["left"].to_numpy() == pytest.approx(lane * LANE_M, abs=0.6)


def test_the_ego_is_overtaken_and_then_overtakes():
    passed_by = [time_abreast(of("overtake", actor)) for actor in ("passing_car", "passing_van", "fast")]
    lorry = of("overtake", "lorry")
    assert max(passed_by) < 7.0 < time_abreast(lorry)
    waiting, passing, after = lorry.loc[:5.0], lorry.loc[11.5:15.0], lorry.iloc[-1:]
    assert waiting["ego_speed"].min() < 26.0 < 31.0 < passing["ego_speed"].min()
    assert waiting["left"].abs().max() < 1.0
    assert passing["left"].to_numpy() == pytest.approx(-LANE_M, abs=0.4)
    assert after["left"].item() > -0.4 * LANE_M  # almost back in the lorry's lane


@pytest.mark.parametrize(("actor", "lane"), [("leaving_car", 1), ("leaving_van", 2)])
def test_leaving_vehicles_cross_the_ego_s_lane_in_front_of_it(actor, lane):
    rows = of("motorway-exit", actor)
    assert drive("motorway-exit").query("name == @actor")["left"].iloc[0] == pytest.approx(lane * LANE_M, abs=0.5)
    assert rows["left"].iloc[-1] < -0.6 * LANE_M
    crossing = rows[rows["left"].abs() < 0.5 * LANE_M]
    assert len(crossing) > 12
    assert crossing["ahead"].between(10.0, GRADED_M).all()


def test_in_the_jam_the_ego_stands_while_neighbours_pass():
    ego = drive("motorway-jam").drop_duplicates("time").set_index("time")["ego_speed"]
    assert (ego < 0.5).sum() * 0.08 > 2.0
    assert ego.loc[:2.0].max() > 4.0
    assert ego.loc[11.0:].max() > 3.0
    beside = of("motorway-jam", "right_3")  # a semitrailer
    assert beside["left"].to_numpy() == pytest.approx(-LANE_M, abs=0.3)
    assert beside["ahead"].iloc[0] > 3.0
    assert beside["ahead"].min() < -4.0
    assert beside["ahead"].iloc[-1] > 3.0
    car = of("motorway-jam", "left_5")
    assert car["ahead"].max() - car["ahead"].min() > 15.0


@pytest.mark.slow
def test_the_car_from_the_ramp_merges_ahead_of_the_ego():
    table = drive("merge-generic-v0")
    merging = table[table["name"] == "car.9"].set_index("time")
    egos_lane = merging["ego_y_world"].iloc[0]
    merges = merging[merging["y_world"].between(egos_lane - 2.0, egos_lane + 0.5)].iloc[0]
    assert merging["y_world"].iloc[0] < egos_lane - 8.0
    assert merging["y_world"].iloc[-1] == pytest.approx(egos_lane, abs=0.5)
    assert 10.0 < merges["ahead"] < 30.0
    assert merging["ego_braking"].loc[merges.name - 1.5 : merges.name + 1.5].max() > 5.5
    assert merging["ego_y_world"].iloc[-1] == pytest.approx(egos_lane + 4.0, abs=0.5)


@pytest.mark.slow
def test_each_lane_is_slower_than_the_one_to_its_left():
    table = drive("exit-v0")
    first = table[table["time"] == 0.0]
    by_lane = first.groupby((-first["left"] / 4.0).round())["speed"].median()
    assert by_lane.is_monotonic_decreasing
    assert len(by_lane) >= 4
    near = table[np.hypot(table["ahead"], table["left"]) < GRADED_M]
    passed = near.groupby("name")["ahead"].agg(lambda ahead: ahead.iloc[0] > 0.0 > ahead.iloc[-1])
    assert passed.sum() >= 12
