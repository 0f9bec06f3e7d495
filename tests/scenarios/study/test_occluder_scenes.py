"""Scenes with moving traffic, rows of narrow occluders and a failed unit, by the ground truth of the sensor."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from support.few import few

from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.study.scenes.scene_parts import BEFORE_S
from luxloop.scenarios.study.staged import behind_row, hidden_behind_wall, hidden_with_failed_unit, passed_by_bus
from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.rig.rig import load_rig
from luxloop.sim.scripted.scripted_source import ScriptedSource

TOLERANCE_S = 0.3
BOXES = {"ideal": True, "layer_overlap": {"enabled": False}}
"""`[noise]` of an exact rig, a level ego, and vehicles that are boxes."""


def seen(document, seed=1):
    """Simulate a scene without a tracker; return the scans, and time, hits on the car and its visible share (3, F)."""
    scenario = Scenario.of({**document, "seed": seed}, Path("scene.toml"))
    source = ScriptedSource(scenario.traffic, Path(), 100.0)
    obstacles = source.reset(seed)
    lidar = Lidar(load_rig("srx_six_lux", Path()), scenario.noise, scenario.sensor, seed, obstacles)
    scans, rows = [], []
    for _ in range(round(scenario.duration_s / source.dt)):
        frame = source.step()
        row = frame.actors.name.tolist().index("car")
        scan, truth = lidar.scan(frame)
        scans.append((frame, scan, truth))
        rows.append((frame.time, truth.hits[row], truth.visible_fraction[row]))
    return scans, np.array(rows).T


@pytest.mark.parametrize(("occlusion_s", "closing_mps"), few([(0.5, 10.0), (1.0, 5.0), (2.0, 4.0)], 0.5))
def test_the_bus_hides_the_car_for_the_given_time(occlusion_s, closing_mps):
    _, (time, hits, visible) = seen(passed_by_bus(occlusion_s, 10.0, closing_mps) | {"noise": BOXES})
    hidden = np.flatnonzero(hits == 0)
    assert len(hidden) * 0.08 == pytest.approx(occlusion_s, abs=TOLERANCE_S)
    assert np.all(np.diff(hidden) == 1)
    assert time[hidden[0]] == pytest.approx(BEFORE_S, abs=TOLERANCE_S)
    assert visible[[0, -1]].min() > 0.9


def test_the_points_in_front_of_the_hidden_car_are_on_the_bus():
    scans, (_, hits, _) = seen(passed_by_bus(1.0))
    frame, _, truth = scans[int(np.flatnonzero(hits == 0)[3])]
    bus = frame.actors.id[frame.actors.name.tolist().index("bus")]
    assert np.count_nonzero(truth.actor_id == bus) > 200


@pytest.mark.parametrize("kind", few(["poles", "fence", "foliage"], "fence"))
@pytest.mark.parametrize("cover", [0.2, 0.6])
def test_a_row_covers_the_given_share_of_the_car(kind, cover):
    """From one to two seconds after the first piece, the car is behind the row for all units that see it."""
    _, (time, _, visible) = seen(behind_row(kind, cover, occlusion_s=3.0) | {"noise": BOXES})
    behind = (time > BEFORE_S + 1.5) & (time < BEFORE_S + 2.5)
    assert visible[behind].mean() == pytest.approx(1.0 - cover, abs=0.12)
    assert visible[time < BEFORE_S - 1.5].min() > 0.95
    assert visible[-1] > 0.95
    flicker = visible[behind].std()
    assert flicker > 0.03 if kind == "poles" else flicker < 0.25


@cache
def seen_with_all_units():
    return seen(hidden_behind_wall(1.0, 10.0))


@pytest.mark.parametrize("unit", few(["front left", "side left", "rear left"], "side left"))
def test_the_failed_unit_is_silent_and_the_others_see_what_they_saw(unit):
    names = [mount.name for mount in load_rig("srx_six_lux", Path()).mounts]
    with_all, (_, hits_before, _) = seen_with_all_units()
    scans, (time, hits, _) = seen(hidden_with_failed_unit(unit, 1.0))
    points, before = (
        np.array([np.bincount(scan.unit, minlength=len(names)) for _, scan, _ in one]) for one in (scans, with_all)
    )
    silent, failed = time >= BEFORE_S - 1.0, names.index(unit)
    assert points[silent, failed].max() == 0
    assert points[~silent, failed].min() > 0
    assert np.delete(points, failed, axis=1).tolist() == np.delete(before, failed, axis=1).tolist()
    assert hits.tolist() == hits_before.tolist()  # rays, before losses: the wall hides the car for the same time


@pytest.mark.parametrize(
    ("stage", "message"),
    [
        (lambda: passed_by_bus(0.0), "occlusion_s = 0"),
        (lambda: passed_by_bus(9.0), "needs a bus of"),
        (lambda: behind_row("hedge", 0.5), 'kind = "hedge"'),
        (lambda: behind_row("poles", 1.0), "cover = 1"),
        (lambda: hidden_with_failed_unit("roof", 1.0), 'unit = "roof"'),
    ],
)
def test_invalid_parameters_raise_a_value_error(stage, message):
    with pytest.raises(ValueError, match=message):
        stage()
