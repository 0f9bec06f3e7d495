"""Replay of recordings: effect of the truth layer, presence of road users, time and place."""

import numpy as np
import pandas as pd
import pytest
from support.traffic import frames, play

from luxloop.sim.actor_draws import paint_reflectivity
from luxloop.sim.physical.body_tables import REAR_AXLE
from luxloop.sim.replay.replay_config import ReplayTraffic
from luxloop.sim.replay.replay_source import ReplaySource
from luxloop.sim.scripted.motions import Arc, LaneChange, Straight, state_at
from luxloop.sim.scripted.script import ScriptedObstacle
from luxloop.sim.source import EgoCommand, SimulatorFailedError, TrafficEndedError, TrafficInputError
from luxloop.sim.world import Kind, Mode

DT = 0.08


def track(name, motion, times, start=(0.0, 0.0, 0.0), **columns):
    """Return rows of one road user that moves by a script from its first time."""
    states = [state_at([motion], np.array(start), time - times[0]).pose for time in times]
    x, y, yaw = np.array(states).T
    rows = {"time_s": times, "id": name, "x_m": x, "y_m": y, "yaw_deg": np.degrees(yaw), "kind": "car"}
    return pd.DataFrame(rows | columns)


def clock(begin, end, rate=25.0):
    return begin + np.arange(round((end - begin) * rate) + 1) / rate


STRAIGHT = Straight("straight", 12.0)


@pytest.fixture
def replay(tmp_path):
    """Return a factory of sources that play tracks from a Parquet file."""

    def make(*tracks, range_m=150.0, **keys):
        pd.concat(tracks).to_parquet(tmp_path / "tracks.parquet")
        config = ReplayTraffic(**{"file": "tracks.parquet", "ego": "ego"} | keys)
        return ReplaySource(config, tmp_path, range_m)

    return make


# ---- effect of the truth layer on a clean recording


@pytest.mark.parametrize("rate", [10.0, 25.0])
@pytest.mark.parametrize(
    "motion",
    [
        Straight("straight", 15.0),
        Straight("straight", 5.0, acceleration_mps2=1.5),
        Straight("straight", 0.0),
        Arc("arc", 8.0, 20.0),
        Arc("arc", 6.0, -12.0),
        LaneChange("lane-change", 15.0, 3.5, 4.0),
    ],
    ids=["steady", "accelerating", "standing", "left", "right", "lane-change"],
)
def test_a_clean_motion_is_preserved(replay, motion, rate):
    """A feasible motion changes by centimetres at most, and its rates stay the same."""
    times, start, length = clock(100.0, 108.0, rate), np.array([30.0, 5.0, 0.4]), 4.5
    arm = length * (REAR_AXLE - 0.5)
    recorded = track("a", motion, times, start, length_m=length)
    yaw = np.radians(recorded["yaw_deg"])
    recorded["x_m"] += arm * np.cos(yaw)
    recorded["y_m"] += arm * np.sin(yaw)
    seen = frames(replay(track("ego", STRAIGHT, times), recorded), round(7.5 / DT))
    for frame in seen[12:]:  # in the first second the body adapts to the turn in which it starts
        actual = state_at([motion], start, frame.time)
        ahead = np.array([np.cos(actual.pose[2]), np.sin(actual.pose[2])])
        left = np.array([-ahead[1], ahead[0]])
        (row,) = np.flatnonzero(frame.actors.name == "a")
        pose = frame.actors.pose_world[row]
        assert pose[:2] == pytest.approx(
            actual.pose[:2] + arm * ahead, abs=0.12
        )  # smoothing over 0.8 s cuts a bend of 3.2 m/s^2 by 0.1 m
        assert np.cos(pose[2] - actual.pose[2]) > np.cos(np.radians(1.0))
        velocity = actual.velocity + arm * actual.yaw_rate * left
        assert frame.actors.velocity_world[row] == pytest.approx(velocity, abs=0.15)
        assert frame.actors.yaw_rate[row] == pytest.approx(actual.yaw_rate, abs=0.02)
        assert np.hypot(*frame.actors.deviation[row]) < 0.12


def test_a_standing_body_is_exactly_still_and_stationary(replay):
    times = clock(0.0, 6.0)
    seen = frames(replay(track("ego", STRAIGHT, times), track("a", Straight("straight", 0.0), times)), 60)
    actors = [frame.actors for frame in seen]
    assert all(np.array_equal(one.pose_world, actors[0].pose_world) for one in actors)
    assert all(not one.velocity_world.any() and list(one.mode) == [Mode.STATIONARY] for one in actors)


# ---- presence


def test_a_gap_is_an_absence_and_the_return_a_new_actor(replay):
    times = clock(0.0, 10.0)
    there = (times <= 2.0) | (times >= 5.0)
    a = track("a", STRAIGHT, times, (0.0, 4.0, 0.0))[there]
    seen = frames(replay(track("ego", STRAIGHT, times), a), 120)
    present = {frame.time: [str(name) for name in frame.actors.name] for frame in seen}
    for time, names in present.items():
        assert names == (["a"] if time <= 2.0 + 1e-9 else ["a#2"] if time >= 5.0 - 1e-9 else [])
    assert {int(number) for frame in seen for number in frame.actors.id} == {1, 2}


def test_actors_enter_the_range_in_motion(replay):
    times = clock(0.0, 12.0)
    oncoming = track("oncoming", STRAIGHT, times, (200.0, 4.0, np.pi))
    seen = frames(replay(track("ego", STRAIGHT, times), oncoming, range_m=60.0), 140)
    gap = [np.hypot(*(frame.actors.pose_world[:, :2] - frame.ego.pose_world[:2]).T) for frame in seen]
    assert all((one <= 60.0).all() for one in gap)
    came = [frame.actors for frame in seen if len(frame.actors)]
    assert 60 < len(came) < 70  # 120 m at 24 m/s
    assert all(one.velocity_world[0] == pytest.approx([-12.0, 0.0], abs=0.02) for one in came)


def test_bodies_match_the_file(replay):
    times = clock(0.0, 2.0)
    bus = track("bus", STRAIGHT, times, (0.0, 4.0, 0.0), kind="bus", length_m=11.0, reflectivity=0.25)
    van = track("van", STRAIGHT, times, (0.0, 8.0, 0.0), kind="van")
    (frame,) = frames(replay(track("ego", STRAIGHT, times, length_m=4.9), bus, van), 1, seed=9)
    assert frame.ego.size[0] == 4.9
    assert list(frame.actors.kind) == [Kind.BUS, Kind.VAN]
    assert frame.actors.size[0] == pytest.approx([11.0, 2.5, 3.4])
    assert frame.actors.reflectivity[0] == 0.25
    assert frame.actors.reflectivity[1] == paint_reflectivity(9, "van", Kind.VAN)


def test_the_seed_only_affects_paint(replay):
    times = clock(0.0, 4.0)
    source = replay(track("ego", STRAIGHT, times), track("a", Arc("arc", 8.0, 20.0), times))
    one, other, again = (frames(source, 40, seed) for seed in (1, 2, 1))
    for a, b, c in zip(one, other, again, strict=True):
        assert np.array_equal(a.actors.pose_world, b.actors.pose_world)
        assert not np.array_equal(a.actors.reflectivity, b.actors.reflectivity)
        assert np.array_equal(a.actors.pose_world, c.actors.pose_world)
        assert np.array_equal(a.actors.reflectivity, c.actors.reflectivity)


def test_the_order_of_the_rows_does_not_matter(replay):
    times = clock(0.0, 4.0)
    tracks = [track("ego", STRAIGHT, times), *(track(name, STRAIGHT, times, (9.0, 4.0, 0.0)) for name in "cab")]
    plain = frames(replay(*tracks), 30)
    shuffled = frames(replay(pd.concat(tracks).sample(frac=1.0, random_state=4)), 30)
    for a, b in zip(plain, shuffled, strict=True):
        assert list(a.actors.name) == list(b.actors.name) == ["a", "b", "c"]
        assert np.array_equal(a.actors.pose_world, b.actors.pose_world)


# ---- time and place


def test_frame_0_is_at_begin_s_or_the_ego_s_first_sample(replay):
    times = clock(40.0, 50.0)
    source = replay(track("ego", STRAIGHT, times), track("a", STRAIGHT, clock(30.0, 50.0), (-100.0, 4.0, 0.0)))
    (frame,) = frames(source, 1)
    assert (frame.index, frame.time) == (0, 0.0)
    assert frame.ego.pose_world == pytest.approx([0.0, 0.0, 0.0], abs=0.02)
    assert frame.actors.pose_world[0] == pytest.approx([20.0, 4.0, 0.0], abs=0.02)
    (later,) = frames(replay(track("ego", STRAIGHT, times), begin_s=43.33), 1)
    assert later.ego.pose_world == pytest.approx([3.33 * 12.0, 0.0, 0.0], abs=0.02)


def test_large_coordinates_are_relative_to_a_near_origin(replay):
    """UTM northings are millions of metres; obstacles are shifted with the actors."""
    times = clock(0.0, 4.0)
    start = (691_234.5, 5_334_567.25, 0.3)
    wall = ScriptedObstacle([(691_200.0, 5_334_600.0), (691_300.0, 5_334_600.0)], kind="wall")
    source = replay(track("ego", STRAIGHT, times, start), obstacle=[wall])
    obstacles = source.reset(1)
    assert list(source.origin) == [690_000.0, 5_330_000.0]
    assert obstacles.vertices_world[0] == pytest.approx([1200.0, 4600.0])
    assert source.step().ego.pose_world == pytest.approx([1234.5, 4567.25, 0.3], abs=0.02)
    near = replay(track("ego", STRAIGHT, times, (4_900.0, -4_900.0, 0.0)))
    near.reset(1)
    assert not near.origin.any()


def test_the_run_ends_with_the_ego_s_samples(replay):
    times = clock(10.0, 14.0)
    source = replay(track("ego", STRAIGHT, times), track("a", STRAIGHT, clock(10.0, 20.0)))
    source.reset(1)
    play(source, 51)  # 0 to 4.0 s
    with pytest.raises(TrafficEndedError, match=r'tracks.parquet: the samples of ego "ego" end at 14.00 s'):
        source.step()
    with pytest.raises(TrafficEndedError):
        source.step()
    source.reset(1)
    assert source.step().index == 0


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"ego": "absent"}, 'ego = "absent" is not among its 3 ids; name one of them: "a", "b", "ego"'),
        ({"begin_s": 3.0}, 'ego "ego" has no motion at 3 s, only 10 to 14 s; choose another begin_s'),
        ({"gap_s": 0.03}, "or raise gap_s = 0.03"),
        ({"file": "missing.csv"}, "missing.csv: no such file in "),
        ({"file": "folder.csv"}, "folder.csv: is a folder; name a file in it"),
        ({"file": "odd.xml"}, "odd.xml: its root is <net>; it should be one of fcd-export, commonRoad"),
        ({"file": "broken.xml.gz"}, "broken.xml.gz: not valid XML: "),
    ],
)
def test_errors_name_file_and_remedy_in_one_line(replay, tmp_path, keys, message):
    (tmp_path / "odd.xml").write_text("<net></net>")
    (tmp_path / "folder.csv").mkdir()
    (tmp_path / "broken.xml.gz").write_bytes(b"no gzip")
    times = clock(10.0, 14.0)
    source = replay(*(track(name, STRAIGHT, times) for name in ("ego", "b", "a")), **keys)
    with pytest.raises(TrafficInputError) as error:
        source.reset(1)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"file": "tracks.json"}, "should end in .csv"),
        ({"dt_s": 0.0}, "must be positive"),
        ({"gap_s": -1.0}, "must be positive"),
    ],
)
def test_keys_out_of_range_are_rejected(keys, message):
    with pytest.raises(ValueError, match=message):
        ReplayTraffic(**{"file": "a.csv", "ego": "1"} | keys)


def test_commands_and_steps_before_reset_are_rejected(replay):
    source = replay(track("ego", STRAIGHT, clock(0.0, 4.0)))
    with pytest.raises(SimulatorFailedError, match="call reset before step"):
        source.step()
    with pytest.raises(TrafficInputError, match="a replay cannot be commanded"):
        source.apply(EgoCommand(speed_mps=3.0))
    source.close()
    source.close()
