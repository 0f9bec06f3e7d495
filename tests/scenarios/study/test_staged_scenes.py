"""Staged scenes against the ground truth of the sensor and of the traffic."""

from pathlib import Path

import numpy as np
import pytest
from support.few import few

from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.study.scenes.hidden_vehicles import BRAKING_MPS2, SIDEWAYS_MPS2, hidden_behind_wall
from luxloop.scenarios.study.scenes.partly_hidden import partly_hidden, standing_car
from luxloop.scenarios.study.scenes.scene_parts import BEFORE_S
from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.rig.rig import load_rig
from luxloop.sim.scripted.scripted_source import ScriptedSource

CAR = 1
SIDE_LEFT = 2
"""Index of the unit in the rig."""
TOLERANCE_S = 0.3
BOXES = {"ideal": True, "layer_overlap": {"enabled": False}}
"""`[noise]` of an exact rig, a level ego, and vehicles that are boxes."""


def traffic(scenario):
    """Yield the obstacles of a scene and its frames, each with the car's row."""
    source = ScriptedSource(scenario.traffic, Path(), 100.0)
    obstacles = source.reset(scenario.seed)
    for _ in range(round(scenario.duration_s / source.dt)):
        frame = source.step()
        yield obstacles, frame, frame.actors.id.tolist().index(CAR)


def scenario_of(document, seed=1):
    return Scenario.of({**document, "seed": seed}, Path("scene.toml"))


def frames(document, seed=1):
    """Simulate a scene without a tracker; yield the frame, the car's row and the scan truth."""
    scenario, lidar = scenario_of(document, seed), None
    for obstacles, frame, row in traffic(scenario):
        if lidar is None:
            lidar = Lidar(load_rig("srx_six_lux", Path()), scenario.noise, scenario.sensor, seed, obstacles)
        _, truth = lidar.scan(frame)
        yield frame, row, truth


def visibility(document, seed=1):
    """Return (F, 3) time, hits on the car and its visible fraction."""
    return np.array(
        [(frame.time, truth.hits[row], truth.visible_fraction[row]) for frame, row, truth in frames(document, seed)]
    )


@pytest.mark.parametrize("manoeuvre", few(["keeps speed", "brakes", "changes lane"], "keeps speed"))
@pytest.mark.parametrize(("occlusion_s", "speed_mps"), few([(0.5, 20.0), (3.0, 5.0)], 0.5))
def test_the_car_is_completely_hidden_for_the_given_time(occlusion_s, speed_mps, manoeuvre):
    """Fails if a LIDAR sees past the end of the wall, or if the wall is longer than necessary.

    The wall is built for the car's box and an exact rig, so the car is a box here; bowed bodies follow below.
    """
    scene = hidden_behind_wall(occlusion_s, speed_mps, manoeuvre) | {"noise": BOXES}
    time, hits, visible = visibility(scene, seed=2).T
    hidden = np.flatnonzero(hits == 0)
    assert len(hidden) * 0.08 == pytest.approx(occlusion_s, abs=TOLERANCE_S)
    assert np.all(np.diff(hidden) == 1)
    assert time[hidden[0]] == pytest.approx(BEFORE_S, abs=TOLERANCE_S)
    assert visible[time < BEFORE_S - 1.2].min() == 1.0


@pytest.mark.parametrize("manoeuvre", ["keeps speed", "brakes", "changes lane"])
@pytest.mark.parametrize(("occlusion_s", "speed_mps"), few([(0.5, 20.0), (3.0, 5.0)], 0.5))
def test_a_bowed_car_is_hidden_as_long_and_seen_later_by_each_unit_that_can(occlusion_s, speed_mps, manoeuvre):
    """A braking car may leave the side unit's field of view, by its bowed corner, before the rear unit sees it."""
    seen = [
        (frame.time, truth.unit_hits[row], truth.unit_hits_alone[row])
        for frame, row, truth in frames(hidden_behind_wall(occlusion_s, speed_mps, manoeuvre), seed=2)
    ]
    time, hits, alone = (np.array(column) for column in zip(*seen, strict=True))
    hidden = np.flatnonzero(hits.sum(axis=1) == 0)
    assert len(hidden) * 0.08 == pytest.approx(occlusion_s, abs=TOLERANCE_S)
    assert time[hidden[0]] == pytest.approx(BEFORE_S, abs=TOLERANCE_S)
    once = hidden[: np.flatnonzero(np.diff(hidden, append=len(time) + 1) > 1)[0] + 1]
    assert len(once) * 0.08 == pytest.approx(occlusion_s, abs=TOLERANCE_S)
    again = np.setdiff1d(hidden, once)
    assert len(again) <= 1
    assert not alone[again, SIDE_LEFT].any()
    assert np.all(time[again] < BEFORE_S + occlusion_s + 0.8)


@pytest.mark.parametrize("occlusion_s", few([0.5, 3.0], 0.5))
@pytest.mark.parametrize("manoeuvre", ["keeps speed", "brakes", "changes lane"])
def test_the_manoeuvre_happens_while_hidden_with_bounded_acceleration(occlusion_s, manoeuvre):
    """Fails on a wrong manoeuvre, one that starts in view, or one above 2 m/s^2."""
    times, speed, sideways, acceleration = [], [], [], []
    for _, frame, row in traffic(scenario_of(hidden_behind_wall(occlusion_s, 10.0, manoeuvre))):
        times.append(frame.time)
        speed.append(frame.actors.velocity_world[row, 0])
        sideways.append(frame.actors.pose_world[row, 1])
        acceleration.append(np.abs(frame.actors.acceleration_world[row]))
    times, (along, across) = np.array(times), np.array(acceleration).T
    assert along.max() <= BRAKING_MPS2 + 1e-6
    assert across.max() <= SIDEWAYS_MPS2 + 1e-6
    in_view = (times < BEFORE_S - 0.1) | (times > BEFORE_S + occlusion_s + 0.1)
    assert max(along[in_view].max(), across[in_view].max()) < 1e-6
    slower = {0.5: 9.0, 3.0: 5.0}[occlusion_s]  # 2 m/s^2 for 0.5 s; for 2.5 s of the 3, to half the speed
    assert speed[-1] == pytest.approx(slower if manoeuvre == "brakes" else 10.0)
    # 2 m/s^2 sideways make sqrt(3) / 10 * 2 * T^2 of a quintic: 0.0866 m in 0.5 s, and 3.118 m in 3 s.
    offset_m = {0.5: 0.0866, 3.0: 3.118}[occlusion_s] if manoeuvre == "changes lane" else 0.0
    assert sideways[-1] - sideways[0] == pytest.approx(offset_m, abs=0.1)


@pytest.mark.parametrize("visible_share", few([0.0, 0.3, 1.0], 0.0, 0.3))
def test_the_screen_leaves_the_given_share_visible_for_the_given_time(visible_share):
    """Fails if the screen moves too far or not far enough, or stays for another time."""
    time, hits, visible = visibility(partly_hidden(visible_share, occlusion_s=1.0)).T
    assert visible[time < BEFORE_S].min() > 0.95
    assert visible[-1] > 0.95
    least = np.flatnonzero(visible < visible.min() + 0.03)
    assert visible.min() == pytest.approx(visible_share, abs=0.12)
    assert (hits.min() == 0) == (visible_share == 0.0)
    if visible_share:
        assert visible.min() > 0.1
    if visible_share < 1.0:
        assert len(least) * 0.08 == pytest.approx(1.0, abs=TOLERANCE_S)


@pytest.mark.parametrize("aspect_deg", [0.0, 30.0, 90.0])
@pytest.mark.parametrize("visible_share", [0.3, 0.6, 1.0])
def test_the_wall_leaves_the_given_share_of_a_stationary_car_visible(visible_share, aspect_deg):
    document = standing_car(15.0, aspect_deg, visible_share) | {"duration_s": 0.2}
    visible = visibility(document)[:, 2]
    assert visible.mean() == pytest.approx(visible_share, abs=0.12)


def test_a_stationary_car_has_the_given_pose():
    frame, row, _ = next(frames(standing_car(20.0, 60.0)))
    assert frame.actors.pose_world[row, :2] == pytest.approx([20.0, 0.0], abs=0.11)
    assert np.degrees(frame.actors.pose_world[row, 2]) == pytest.approx(60.0, abs=2.1)


@pytest.mark.parametrize(
    ("stage", "message"),
    [
        (lambda: hidden_behind_wall(-1.0, 10.0), "occlusion_s = -1"),
        (lambda: hidden_behind_wall(1.0, 10.0, "flies"), 'manoeuvre = "flies"'),
        (lambda: partly_hidden(1.5), "visible_share = 1.5"),
        (lambda: partly_hidden(0.5, speed_mps=3.0), "speed_mps = 3"),
        (lambda: standing_car(visible_share=-0.1), "visible_share = -0.1"),
        (lambda: standing_car(5.0), "range_m = 5"),
    ],
)
def test_invalid_scene_parameters_raise_a_value_error(stage, message):
    with pytest.raises(ValueError, match=message):
        stage()
