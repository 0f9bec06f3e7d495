"""The traffic source of OpenSCENARIO files: the shipped example and the public ones, against numbers of the files."""

from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from support.paths import EXAMPLES
from support.real_data import real_file
from support.storyboards import STEP_S, act, after, at, document, event, first_time, network, speed, trigger

from luxloop.scenarios.errors import ScenarioError
from luxloop.scenarios.files.scenario import Scenario
from luxloop.sim.opendrive.road_network import read_network
from luxloop.sim.openscenario.openscenario_config import OpenScenarioTraffic
from luxloop.sim.openscenario.openscenario_source import OpenScenarioSource
from luxloop.sim.openscenario.storyboard_elements import read_storyboard
from luxloop.sim.openscenario.storyboard_run import StoryboardRun
from luxloop.sim.source import EgoCommand, SimulatorFailedError, TrafficEndedError, TrafficInputError
from luxloop.sim.world import Kind

PUBLIC = "openscenario/xosc/{}.xosc"


def source_of(path, ego="Ego", **keys):
    return OpenScenarioSource(OpenScenarioTraffic(file=path.name, ego=ego, **keys), path.parent, 200.0)


def frames_of(source, count):
    with closing(source):
        source.reset(1)
        return [source.step() for _ in range(count)]


def public_run(name):
    board, roads = read_storyboard(real_file(PUBLIC.format(name)), {})
    return StoryboardRun(board, read_network(roads))


def ends(run, event):
    return first_time(run, lambda run: run.has_state(("event", event), "completeState"))


# ---- the shipped example


def test_the_example_cuts_in_as_its_file_says():
    """Ego 25 m/s at s = 60; the overtaker at 32 m/s starts 20 m behind and changes lanes 0.8 s, that is 20 m, ahead."""
    frames = frames_of(source_of(EXAMPLES / "cut-in.xosc"), 180)
    ahead = np.array([frame.actors.pose_world[0, :2] - frame.ego.pose_world[:2] for frame in frames])
    time = np.array([frame.time for frame in frames])
    assert frames[0].actors.name.tolist() == ["Overtaker", "Bus"]
    assert frames[0].actors.kind.tolist() == [Kind.CAR, Kind.BUS]
    assert frames[0].ego.size.tolist() == [4.83, 1.91, 1.67]
    assert ahead[0] == pytest.approx([-20.05, 3.5], abs=0.02), "box centres: 1.35 m and 1.4 m ahead of the rear axles"
    before = time < 5.5
    assert ahead[before, 0] == pytest.approx(-20.05 + 7 * time[before], abs=0.02)
    begins = 40 / 7
    road = read_network(EXAMPLES / "cut-in.xodr")
    half_way, ended = (frames[np.searchsorted(time, begins + after)] for after in (2.0, 4.2))
    assert road.nearest(*half_way.actors.pose_world[0, :2])[2] == pytest.approx(-3.5, abs=0.2)
    assert road.nearest(*ended.actors.pose_world[0, :2])[2] == pytest.approx(-5.25, abs=0.1)
    slowed = frames[np.searchsorted(time, begins + 4 + 0.5 + 3.5 + 0.5)]
    assert np.hypot(*slowed.actors.velocity_world[0]) == pytest.approx(25.0, abs=0.05)


def test_parameters_change_the_example():
    slow = frames_of(source_of(EXAMPLES / "cut-in.xosc", parameters={"Speed": "10"}), 1)[0]
    assert slow.ego.velocity_world[0] == pytest.approx(10.0, abs=0.01)
    assert slow.actors.velocity_world[0, 0] == pytest.approx(14.0, abs=0.01)


def test_the_run_ends_with_the_road_of_the_ego(tmp_path):
    for suffix in ("xosc", "xodr"):
        text = (EXAMPLES / f"cut-in.{suffix}").read_text(encoding="utf-8")
        (tmp_path / f"cut-in.{suffix}").write_text(text.replace('s="60"', 's="950"'), encoding="utf-8")
    source = source_of(tmp_path / "cut-in.xosc")
    with closing(source):
        source.reset(1)
        for _ in range(26):  # 50 m at 25 m/s
            source.step()
        with pytest.raises(
            TrafficEndedError, match=r"cut-in\.xosc: ego .Ego. reached the end of its road before 2\.08 s"
        ):
            source.step()


def test_errors_of_the_source(tmp_path):
    source = source_of(EXAMPLES / "cut-in.xosc", "Absent")
    with pytest.raises(TrafficInputError, match='ego = "Absent" is no entity; use one of Ego, Overtaker, Bus'):
        source.reset(1)
    with pytest.raises(TrafficInputError, match=r"absent\.xosc: no such file in"):
        source_of(Path("absent.xosc")).reset(1)
    (tmp_path / "folder.xosc").mkdir()
    with pytest.raises(TrafficInputError, match=r"folder\.xosc: is a folder; name a file in it"):
        source_of(tmp_path / "folder.xosc").reset(1)
    with pytest.raises(TrafficInputError, match="accepts no"):
        source.apply(EgoCommand(speed_mps=1.0))
    with pytest.raises(SimulatorFailedError, match="call reset"):
        source.step()


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ('file = "a.xml"\nego = "E"', r'file = "a\.xml" should end in \.xosc'),
        ('file = "a.xosc"', "ego"),
        ('file = "a.xosc"\nego = "E"\nstep_s = 0.2', r"step_s = 0\.2 should be at least 0\.001 s"),
    ],
)
def test_errors_of_the_scenario_file(tmp_path, keys, message):
    path = tmp_path / "a.toml"
    path.write_text(
        f'description = "d"\nduration_s = 1.0\n[traffic]\nkind = "openscenario"\n{keys}\n', encoding="utf-8"
    )
    with pytest.raises(ScenarioError, match=message):
        Scenario.load(path)


# ---- the public examples


def test_cut_in_changes_lanes_and_brakes_at_its_headways():
    """Ego 30 m/s; the overtaker starts 25 m behind at 1.2 times its speed: 12 m (0.4 s) ahead after 37 / 6 s, 21 m
    (0.7 s) after 46 / 6 s. The lane change takes 3 s over 0.5 x (3.65 + 3.5) m; braking 36 m/s at 4 m/s^2 takes 9 s.
    """
    run = public_run("cut-in")
    lateral = []
    assert first_time(run, lambda run: run.has_state(("event", "CutInEvent"), "runningState")) == pytest.approx(
        37 / 6, abs=2 * STEP_S
    )
    begun = run.time
    while run.has_state(("event", "CutInEvent"), "runningState"):
        lateral.append((run.time - begun, run.travellers["OverTaker"].t))
        run.advance(STEP_S)
    assert run.time - begun == pytest.approx(3.0, abs=2 * STEP_S)
    time, t = np.array(lateral).T
    assert t == pytest.approx(-4.425 - 3.575 * (1 - np.cos(np.pi * time / 3)) / 2, abs=1e-6)
    assert ends(run, "OvertakerBrakeEvent") == pytest.approx(46 / 6 + 9, abs=0.05)
    assert run.travellers["OverTaker"].speed == 0.0
    assert first_time(run, lambda run: run.stopped) == pytest.approx(46 / 6 + 9 + 5, abs=0.06)


def test_slow_lead_vehicle_brakes_at_its_time_to_collision():
    """150 m ahead and 29 m/s slower: 2.7 s are left after 150 / 29 - 2.7 s; braking 30 m/s at 6 m/s^2 takes 5 s."""
    run = public_run("slow-lead-vehicle")
    begins = first_time(run, lambda run: run.has_state(("event", "brake_Event"), "runningState"))
    assert begins == pytest.approx(150 / 29 - 2.7, abs=STEP_S)
    assert ends(run, "brake_Event") == pytest.approx(begins + 5, abs=2 * STEP_S)
    assert run.travellers["Ego"].s == pytest.approx(50 + 30 * begins + 75, abs=0.05)
    slower = begins + 29 / 6  # the ego is slower than the lead's 1 m/s
    assert first_time(run, lambda run: run.stopped) == pytest.approx(slower + 4, abs=3 * STEP_S)


def test_straight_road_has_constant_speeds():
    run = public_run("straight_500m")
    while run.time < 10:
        run.advance(STEP_S)
    assert run.travellers["Ego"].pose == pytest.approx((250.0, -1.535, 0.0))
    assert run.travellers["Target"].pose == pytest.approx((350.0, -1.535, 0.0))


def test_highway_merge_passes_the_direct_junction_and_merges():
    """The ego drives 25 m/s over 90.64 + 66.14 m of ramps to road 0; at s = 20 - 1 m there it changes to lane -2."""
    run = public_run("highway_merge")
    begins = first_time(run, lambda run: run.has_state(("event", "EgoLaneChangeEvent"), "runningState"))
    assert run.travellers["Ego"].road.id == "0"
    assert begins == pytest.approx((100.64 - 10 + 66.139 + 19) / 25, abs=0.05)
    assert ends(run, "EgoLaneChangeEvent") == pytest.approx(begins + 2.8, abs=2 * STEP_S)
    ego = run.travellers["Ego"]
    assert (ego.lane, ego.t) == (-2, pytest.approx(3.5 - 3.5 - 1.75, abs=1e-6))
    assert run.travellers["A5"].speed == pytest.approx(40.0)


@pytest.mark.parametrize(
    ("name", "line"),
    [
        (
            "acc-test",
            '<ObjectController> of ScenarioObject "Ego" assigns the controller "ACCController"',
        ),
        (
            "synchronize",
            '<ObjectController> of ScenarioObject "Ego" assigns the controller "interactiveDriver"',
        ),
        ("lane_change_simple", '<TeleportAction> of Action "End Of Road teleport action" is supported in Init only'),
    ],
)
def test_the_other_public_examples_are_refused_by_name(name, line):
    path = real_file(PUBLIC.format(name))
    with pytest.raises(TrafficInputError) as error:
        source_of(path).reset(1)
    assert str(error.value).startswith(f"{name}.xosc, line ")
    assert line in str(error.value)
    assert "\n" not in str(error.value)


def test_an_event_that_never_starts_is_a_warning(tmp_path):
    """The first event starts after 5 s, the second after the ego has left its road of 500 m at 50 m/s."""
    network(tmp_path)
    events = [event(speed(50), trigger(after(seconds)), name=name) for name, seconds in (("early", 5), ("late", 30))]
    (tmp_path / "a.xosc").write_text(document({"Ego": at(10) + speed(50)}, act(*events, start=trigger(after(0)))))
    source = source_of(tmp_path / "a.xosc")
    source.reset(1)
    (warning,) = source.warnings
    assert warning.startswith("a.xosc: events that do not start until 9.")
    assert warning.endswith(": late; check their triggers")


def test_the_example_has_no_idle_event():
    source = source_of(EXAMPLES / "cut-in.xosc")
    source.reset(1)
    assert source.warnings == ()
