"""Occlusion scenarios: the described occlusions happen, by ground truth, without tracker."""

import tomllib
from dataclasses import fields, replace

import numpy as np
import pytest
from support.few import few
from support.scanned import ahead, load, played, row, scans

from luxloop.scenarios.files.shipped import CATALOG
from luxloop.scenarios.grading.plane_geometry import iou_table
from luxloop.sensor_model.truth import View

FAMILY = sorted(path.stem for path in (CATALOG / "occlusion").glob("*.toml"))
DT_S = 0.08
SHADOWS = {
    "truck-shadow-500ms": 0.5,
    "truck-shadow-1s": 1.0,
    "truck-shadow-2s": 2.0,
    "truck-shadow-3s": 3.0,
}
"""Duration of the occlusion by the truck [s]."""


def without(frame, name):
    """Return the frame without an actor."""
    actors, others = frame.actors, frame.actors.name != name
    return replace(frame, actors=type(actors)(**{f.name: getattr(actors, f.name)[others] for f in fields(actors)}))


def every(count):
    return lambda frame: frame.index % count == 0


def runs(flags):
    """Return the first and last index of each run of true flags."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    return list(zip(edges[::2], edges[1::2] - 1, strict=True))


@pytest.mark.parametrize("seed", few([1, 2], 1))
@pytest.mark.parametrize(("name", "hidden_s"), SHADOWS.items())
def test_the_truck_occludes_the_car_once_for_the_given_time(name, hidden_s, seed):
    """Rays under the truck's floor, over its hood or past its end would shorten the time."""
    near = [*scans(name, seed=seed, when=lambda frame: -2.0 < ahead(frame, "hidden car") < 13.0)]
    car = row(near[0].frame, "hidden car")
    hits = np.array([instant.truth.hits[car] for instant in near])
    assert all(instant.truth.hits_alone[car] > 0 for instant in near)
    ((first, last),) = runs(hits == 0)
    assert first > 0
    assert last < len(near) - 1
    assert (last - first + 1) * DT_S == pytest.approx(hidden_s, abs=0.1)
    assert not any(instant.points[car] for instant in near[first : last + 1])


@pytest.mark.parametrize("name", SHADOWS)
def test_the_occlusion_is_within_the_grader_s_time_limit(name):
    """Otherwise the occlusion is not counted, and its metric has no value."""
    grading = load(name).grading
    near = [*scans(name, when=lambda frame: -2.0 < ahead(frame, "hidden car") < 13.0)]
    graded = np.array([instant.graded[row(instant.frame, "hidden car")] for instant in near])
    ((first, last),) = runs(~graded)
    assert (last - first + 2) * DT_S <= grading.memory_s


def test_the_files_differ_only_in_speed_and_duration():
    """Only the car's start and speed, and the duration of the run, may differ between the four files."""
    scenes = [tomllib.loads((CATALOG / "occlusion" / f"{name}.toml").read_text(encoding="utf-8")) for name in SHADOWS]
    slower = [scene["traffic"]["ego"]["motion"][0]["speed_mps"] for scene in scenes]
    speeds = [scene["traffic"]["actor"][1]["motion"][0].pop("speed_mps") for scene in scenes]
    widths = (np.array(speeds) - slower) * list(SHADOWS.values())
    assert widths == pytest.approx(widths[0], rel=1e-3)
    for scene in scenes:
        del scene["traffic"]["actor"][1]["x_m"]
    assert all(scene["traffic"] == scenes[0]["traffic"] for scene in scenes)


def test_only_the_bus_occludes_the_crossing_car():
    name = "cross-traffic-behind-bus"
    seen = [*scans(name, when=every(2))]
    fraction = np.array([i.truth.visible_fraction[row(i.frame, "crossing car")] for i in seen])
    ((first, last),) = runs(fraction == 0.0)
    assert (last - first + 1) * 2 * DT_S == pytest.approx(1.7, abs=0.2)
    assert fraction[0] == fraction[first - 4] == fraction[last + 5] == fraction[-1] == 1.0
    behind_bus = {i.frame.index for i in seen[first : last + 1]}
    for instant in scans(name, when=lambda f: f.index in behind_bus, change=lambda f: without(f, "bus")):
        assert instant.truth.visible_fraction[row(instant.frame, "crossing car")] == 1.0


def test_the_crossing_car_reappears_in_front_of_the_ego_which_stops_in_time():
    _, frames = played("cross-traffic-behind-bus")
    car, last = row(frames[0], "crossing car"), frames[-1]
    across = np.array([frame.actors.pose_world[car, 1] for frame in frames])
    assert across[0] < -30.0
    assert across[-1] > 30.0
    crossing = frames[int(np.argmax(across > 0.0))]
    assert 5.0 < ahead(crossing, "crossing car") < 20.0
    assert np.hypot(*last.ego.velocity_world) == 0.0


def test_the_crossing_car_occludes_the_van():
    seen = scans("cross-traffic-behind-bus", when=lambda frame: 4.6 < frame.time < 6.0)
    fraction = np.array([i.truth.visible_fraction[row(i.frame, "waiting van")] for i in seen])
    assert fraction[0] == fraction[-1] == 1.0
    assert fraction.min() == 0.0


def test_the_cars_change_order_while_both_are_occluded():
    _, frames = played("swap-behind-truck")
    lead = np.array([ahead(frame, "fast car") - ahead(frame, "slow car") for frame in frames])
    swap = int(np.flatnonzero(lead > 0.0)[0])
    assert lead[0] < -5.0
    assert lead[-1] > 5.0
    cars = [row(frames[0], "fast car"), row(frames[0], "slow car")]
    for instant in scans("swap-behind-truck", when=lambda frame: abs(frame.index - swap) < 5):
        assert not instant.truth.hits[cars].any()
    for instant in scans("swap-behind-truck", when=lambda frame: frame.index in (20, 100)):
        assert np.all(instant.points[cars] >= 10)


def test_inner_vehicles_of_the_column_are_alternately_visible_and_occluded():
    seen = [*scans("convoy", when=every(4))]
    inner = [row(seen[0].frame, name) for name in ("third", "fourth", "last")]
    fraction = np.array([i.truth.visible_fraction[inner] for i in seen])
    half = (fraction > 0.1) & (fraction < 0.9)
    assert np.mean(half.any(axis=1)) > 0.8
    for one in fraction.T:
        shown = np.flatnonzero(one > 0.5)
        assert one[shown[0] : shown[-1]].min() < 0.1
    next_to_ego = [row(seen[0].frame, name) for name in ("second", "behind")]
    assert all(np.all(i.truth.visible_fraction[next_to_ego] == 1.0) for i in seen)


@pytest.mark.parametrize(("name", "view"), [("rear-only", View.REAR), ("side-only", View.SIDE)])
def test_only_one_side_is_visible(name, view):
    for instant in scans(name, when=every(5)):
        assert np.all(instant.truth.view == view), instant.frame.time
        assert np.all(instant.graded)
        assert np.all(instant.truth.visible_fraction == 1.0)


def test_the_followed_car_is_near_and_far():
    _, frames = played("rear-only")
    gap = np.array([ahead(frame, "followed car") for frame in frames])
    assert gap[0] == pytest.approx(22.0, abs=0.1)
    assert gap.min() == pytest.approx(13.0, abs=0.1)
    assert gap[-1] == pytest.approx(31.0, abs=0.5)


@pytest.mark.parametrize("name", FAMILY)
def test_vehicles_do_not_overlap(name):
    _, frames = played(name)
    for frame in frames[::5]:
        poses = np.vstack([frame.ego.pose_world, frame.actors.pose_world])
        sizes = np.vstack([frame.ego.size, frame.actors.size])[:, :2]
        boxes = np.hstack([poses, sizes])
        assert np.triu(iou_table(boxes, boxes), k=1).max() == 0.0, frame.time
