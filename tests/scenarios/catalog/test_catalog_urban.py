"""Urban scenarios: the described events happen in the traffic, without sensor."""

import math
from contextlib import closing
from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
from shapely.geometry import LineString, Polygon
from shapely.ops import unary_union

from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.files.shipped import paths
from luxloop.sim.highway.highway_source import HighwaySource
from luxloop.sim.scripted.scripted_source import ScriptedSource
from luxloop.sim.sumo.sumo_source import SumoSource
from luxloop.sim.world import Ego, Kind, Mode, WorldFrame

SOURCES = {"sumo": SumoSource, "highway-env": HighwaySource, "scripted": ScriptedSource}
GRADED_M = 50.0


@dataclass(frozen=True)
class Played:
    """Traffic of a complete scenario."""

    actors: pd.DataFrame
    """A row per actor and frame: name, time, x, y, yaw (unwrapped), speed, range, ahead, left, ..."""
    egos: list[Ego]
    time: np.ndarray
    houses: object
    """All obstacles, as one shapely geometry."""

    def of(self, name):
        """Return the rows of one actor in order of time."""
        return self.actors[self.actors["name"] == name].reset_index(drop=True)


@cache
def played(name):
    scenario = Scenario.load(paths()[name])
    with closing(SOURCES[scenario.traffic.kind](scenario.traffic, scenario.folder, 150.0)) as source:
        obstacles = source.reset(scenario.seed)
        frames = [source.step() for _ in range(round(scenario.duration_s / source.dt))]
    table = pd.concat([rows(frame) for frame in frames], ignore_index=True)
    table["yaw"] = table.groupby("name")["yaw"].transform(np.unwrap)
    outlines = np.split(obstacles.vertices_world, obstacles.offset[1:-1])
    houses = unary_union([Polygon(outline) for outline in outlines if len(outline) > 2])
    return Played(table, [frame.ego for frame in frames], np.array([frame.time for frame in frames]), houses)


def rows(frame: WorldFrame):
    """Return the actors of a frame; `ahead` and `left` [m] are box centres in the ego frame."""
    actors, ego = frame.actors, frame.ego
    apart = actors.pose_world[:, :2] - ego.pose_world[:2]
    cos, sin = math.cos(ego.pose_world[2]), math.sin(ego.pose_world[2])
    return pd.DataFrame(
        {
            "name": actors.name,
            "kind": actors.kind,
            "mode": actors.mode,
            "frame": frame.index,
            "time": frame.time,
            "x": actors.pose_world[:, 0],
            "y": actors.pose_world[:, 1],
            "yaw": actors.pose_world[:, 2],
            "length": actors.size[:, 0],
            "width": actors.size[:, 1],
            "speed": np.hypot(*actors.velocity_world.T),
            "range": np.hypot(*apart.T),
            "ahead": apart @ (cos, sin),
            "left": apart @ (-sin, cos),
        }
    )


def turned_deg(actor):
    """Return the change of an actor's yaw from its first to its last frame [deg]."""
    return math.degrees(actor["yaw"].iloc[-1] - actor["yaw"].iloc[0])


# ---- the T-junction

EYES = [(2.165, 0.75), (2.165, -0.75), (1.215, 0.93), (1.215, -0.93), (-2.235, 0.80), (-2.235, -0.80)]
"""[m] The rig's units in the ego frame: from the rear axle, 1.385 m behind the centre."""


def placed(pose, points):
    """Transform points (N, 2) from a body frame to the world."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    return np.asarray(points) @ np.array([[cos, sin], [-sin, cos]]) + pose[:2]


def in_sight(run, row):
    """Return True if a line from a unit to a corner or side of an actor is not blocked by houses."""
    half = np.array([row["length"], row["width"]]) / 2
    outline = placed(row[["x", "y", "yaw"]].to_numpy(float), [(x, y) * half for x in (1, 0, -1) for y in (1, 0, -1)])
    eyes = placed(run.egos[row["frame"]].pose_world, EYES)
    return any(not LineString([eye, point]).intersects(run.houses) for eye in eyes for point in outline)


def test_houses_at_the_t_junction_occlude_crossing_vehicles_until_late():
    run = played("t-junction")
    for name in [f"{side}_{number}" for side in ("left", "right") for number in (1, 2, 3, 4)]:
        crosser = run.of(name)
        near = crosser[crosser["range"] < GRADED_M]
        first = next(row for _, row in near[::3].iterrows() if in_sight(run, row))
        assert 15.0 < first["range"] < 37.0
        assert first["speed"] > 7.0


def test_the_ego_gives_way_at_the_t_junction_and_turns_left():
    run = played("t-junction")
    yaw = np.unwrap([ego.pose_world[2] for ego in run.egos])
    goes = run.time[yaw > yaw[0] + math.radians(10)][0]
    assert math.degrees(yaw[-1] - yaw[0]) > 60.0
    for name in ("left_1", "left_3", "left_4", "right_1", "right_2", "right_4"):
        crosser = run.of(name)
        assert crosser["time"][np.abs(crosser["x"]).idxmin()] < goes, (
            f"{name} should pass the side street before the ego"
        )
    assert turned_deg(run.of("left_2")) == pytest.approx(-90.0, abs=2.0)
    assert turned_deg(run.of("right_3")) == pytest.approx(90.0, abs=2.0)


# ---- the queue

GREEN_S = 4.5


def test_the_queue_stands_until_green_and_starts_one_after_the_other():
    run = played("queue-discharge")
    ego_speed = np.array([np.hypot(*ego.velocity_world) for ego in run.egos])
    starts = {"ego": run.time[ego_speed > 1.0][0]}
    for lane in ("inner", "outer"):
        for number in (1, 2, 3, 4, 5):
            if (name := f"{lane}_{number}") != "inner_3":  # the ego
                waiting = run.of(name)
                assert waiting["time"].iloc[0] == 0.0
                assert waiting["speed"][waiting["time"] < GREEN_S - 0.5].max() < 0.1
                starts[name] = waiting["time"][waiting["speed"] > 1.0].min()
    for queue in (
        ["inner_1", "inner_2", "ego", "inner_4", "inner_5"],
        ["outer_1", "outer_2", "outer_3", "outer_4", "outer_5"],
    ):
        assert starts[queue[0]] > GREEN_S
        assert all(0.3 < starts[later] - starts[earlier] < 1.5 for earlier, later in pairwise(queue))
    assert ego_speed[-1] > 10.0


# ---- the U-turns


@pytest.mark.parametrize("name", ["turns_east", "turns_west"])
def test_u_turns_are_visible_to_the_ego(name):
    run = played("u-turn")
    turner = run.of(name)
    assert turned_deg(turner) == pytest.approx(180.0, abs=1.0)
    turning = turner[(turner["yaw"] - turner["yaw"].iloc[0]).between(math.radians(10), math.radians(170))]
    assert turning["range"].max() < GRADED_M
    assert turning["range"].min() < 20.0
    assert turning["time"].iloc[-1] - turning["time"].iloc[0] < 4.0


def test_one_u_turn_ends_ahead_of_the_ego_and_one_on_the_other_carriageway():
    run = played("u-turn")
    ahead, across = (run.of(name).iloc[-1] for name in ("turns_east", "turns_west"))
    assert ahead["ahead"] > 10.0
    assert abs(ahead["left"]) < 0.5
    assert across["left"] > 10.0


# ---- the bus


def test_the_bus_pulls_in_stands_and_pulls_out_as_the_ego_passes():
    bus = played("bus-stop").of("bus")
    (kind,) = bus["kind"].unique()
    assert kind == Kind.BUS
    stands = bus[bus["speed"] == 0.0]
    lane, bay = bus["y"].iloc[0], stands["y"].iloc[0]
    assert lane - bay > 3.0
    assert 3.0 < stands["time"].iloc[-1] - stands["time"].iloc[0] < 6.0
    assert stands["ahead"].iloc[0] > 0.0 > stands["ahead"].iloc[-1], "the ego should pass it while it stands"
    assert bus["y"].iloc[-1] - bay > 2.0, "it should be on its way back into the lane"
    assert bus["range"].max() < GRADED_M


def test_people_and_cars_pass_the_bus():
    run = played("bus-stop")
    bus = run.of("bus")
    stands = bus[bus["speed"] == 0.0]
    during = run.actors[run.actors["time"].between(stands["time"].min(), stands["time"].max())]
    beside = during[np.abs(during["x"] - stands["x"].iloc[0]) < 12.0]
    assert (beside["kind"] == Kind.PEDESTRIAN).groupby(beside["name"]).any().sum() >= 3
    assert beside["name"].isin(["comes_1", "comes_2", "comes_3"]).any()


# ---- the row of parked cars


def test_gaps_between_parked_cars_are_less_than_a_metre():
    cars = played("parked-row").actors
    cars = cars[cars["frame"] == 0]
    for side in ("right", "left"):
        row = cars[cars["name"].str.startswith(side) | ((side == "right") & (cars["name"] == "puller"))].sort_values(
            "x"
        )
        gaps = (row["x"] - row["length"] / 2).to_numpy()[1:] - (row["x"] + row["length"] / 2).to_numpy()[:-1]
        ahead_of_puller = (row["name"] == "puller").to_numpy()[:-1]
        assert ((gaps > 0.58) & (gaps < 1.02))[~ahead_of_puller].all()
        assert (gaps[ahead_of_puller] > 7.0).all()
        assert len(row) >= 5


def test_one_of_the_parked_cars_pulls_out_ahead_of_the_ego():
    run = played("parked-row")
    parked = run.actors[run.actors["name"].str.contains("right|left")]
    assert (parked["mode"] == Mode.STATIONARY).all()
    puller = run.of("puller")
    assert puller["time"][puller["speed"] > 0].iloc[0] == pytest.approx(2.0, abs=0.1)
    assert puller["left"].iloc[0] < -2.5
    assert abs(puller["left"].iloc[-1]) < 0.1
    assert puller["ahead"].min() > 6.0, "it should never be beside the ego"
    assert math.degrees(puller["yaw"].max()) > 20.0


# ---- highway-env's crossing


@pytest.mark.slow
def test_cars_come_from_all_four_sides_and_turn_in_all_directions():
    run = played("intersection-v0")
    lives = [actor for _, actor in run.actors.groupby("name") if (actor["range"] < GRADED_M).sum() > 50]
    came = {round(math.degrees(actor["yaw"].iloc[0]) / 90.0) % 4 for actor in lives}
    assert came == {0, 1, 2, 3}
    turns = [turned_deg(actor) for actor in lives]
    assert max(turns) > 60.0
    assert min(turns) < -60.0
    ego_yaw = np.unwrap([ego.pose_world[2] for ego in run.egos])
    assert math.degrees(ego_yaw[-1] - ego_yaw[0]) == pytest.approx(90.0, abs=10.0)


# ---- the roundabout


def test_the_ego_waits_beside_a_van_gives_way_to_two_and_drives_half_round():
    run = played("two-lane-roundabout")
    ego_speed = np.array([np.hypot(*ego.velocity_world) for ego in run.egos])
    stops, goes = run.time[ego_speed < 0.2][[0, -1]]
    van = run.of("beside")
    van = van[van["time"].between(stops, goes)]
    assert van["kind"].eq(Kind.VAN).all()
    assert van["range"].max() < 4.0
    for name in ("rings_1", "rings_4"):
        crossing = run.of(name)
        crossing = crossing[crossing["time"].between(stops - 1.0, goes)]
        assert crossing["left"].iloc[0] > 0.0 > crossing["left"].iloc[-1], f"{name} should cross ahead of the ego"
        assert (crossing["ahead"] > 0.0).all()
    x, y = run.egos[-1].pose_world[:2]
    assert y > 20.0 > x, "it should drive from the south arm to the north arm"


# ---- highway-env's half circle


def test_the_ego_and_the_car_ahead_turn_at_the_same_time():
    run = played("u-turn-v0")
    ego_yaw = np.unwrap([ego.pose_world[2] for ego in run.egos])
    assert math.degrees(ego_yaw[-1] - ego_yaw[0]) > 90.0
    ahead = run.of("car.1")
    assert ahead["range"].max() < GRADED_M
    assert turned_deg(ahead) == pytest.approx(180.0, abs=10.0)
    both = (np.abs(np.gradient(ahead["yaw"])) > 0.01) & (np.abs(np.gradient(ego_yaw)) > 0.01)
    assert both.sum() > 25, "for at least two seconds"


# ---- the ramp


def test_the_ego_climbs_the_ramp_behind_a_van_that_stops_and_four_come_down():
    run = played("ramp")
    height = np.array([ego.ground_z for ego in run.egos])
    assert height[0] == 0.0
    assert height[-1] == pytest.approx(9.0, abs=0.05), "over the crest"
    travelled = np.hypot(*np.diff([ego.pose_world[:2] for ego in run.egos], axis=0).T)
    climbing = (height[1:] > 0.5) & (height[1:] < 8.5) & (travelled > 0.1)
    assert np.diff(height)[climbing] / travelled[climbing] == pytest.approx(np.full(climbing.sum(), 0.06), abs=0.003)
    van = run.of("van")
    stands = van[van["speed"] < 0.05]
    assert stands["time"].iloc[-1] - stands["time"].iloc[0] == pytest.approx(2.0, abs=0.2)
    assert stands["x"].between(210.0, 340.0).all(), "on the ramp"
    assert (stands["ahead"] > 5.0).all()
    for number in range(1, 5):
        oncoming = run.of(f"oncoming_{number}")
        assert oncoming["x"].iloc[0] > oncoming["x"].iloc[-1]
        met = oncoming[oncoming["range"] == oncoming["range"].min()]
        assert met["x"].between(200.0, 350.0).all(), "it should meet the ego on the ramp"
