"""Ground truth of visibility in scenes with known results."""

from dataclasses import replace

import numpy as np
import pytest
from support import traffic
from support.few import few
from support.sensor_scenes import CENTRE_RAY, EGO_FRONT, EXACT, LUX_RIG, PLAIN, ActorSpec, ahead, scan, wall

from luxloop.scenarios.files import shipped
from luxloop.scenarios.files.scenario import Scenario
from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.rig.rig import load_rig
from luxloop.sensor_model.truth import NO_ACTOR, Cause, Face, Part, View
from luxloop.sensor_model.visibility import MAX_CLEAN_DEPTH
from luxloop.sim.scripted.scripted_source import ScriptedSource
from luxloop.sim.world import Kind

HEAD_ON = np.pi


@pytest.mark.parametrize("seed", few([1, 2], 1))
def test_truck_of_the_occlusion_scenario_hides_the_car_from_every_beam(seed):
    """Fails if a ray passes under the truck's floor or over its hood."""
    scenario = Scenario.load(shipped.find("truck-shadow"))
    source = ScriptedSource(scenario.traffic, scenario.folder, 200.0)
    rig = load_rig(str(scenario.rig), scenario.folder)
    lidar = Lidar(rig, scenario.noise, scenario.sensor, seed, source.reset(seed))
    for frame in traffic.frames(source, 100, seed):
        (car,) = np.flatnonzero(frame.actors.name == "hidden car")
        _, truth = lidar.scan(frame)
        if 3.8 <= frame.time <= 4.85:
            assert truth.hits[car] == np.sum(truth.actor_id == frame.actors.id[car]) == 0 < truth.hits_alone[car]
            assert truth.visible_fraction[car] == 0.0
        elif frame.time <= 2.2 or frame.time >= 6.4:
            assert truth.visible_fraction[car] == 1.0


@pytest.mark.parametrize(
    ("actor", "faces", "view"),
    [
        (ahead(10), Face.REAR, View.REAR),
        (ActorSpec(15, 0, HEAD_ON), Face.FRONT, View.FRONT),
        (ActorSpec(0, 3.5), Face.RIGHT, View.SIDE),
        (ActorSpec(0, 3.5, HEAD_ON), Face.LEFT, View.SIDE),
        (ahead(6, y=3.5), Face.REAR | Face.RIGHT, View.L_SHAPE),
        (ahead(6, y=-3.5), Face.REAR | Face.LEFT, View.L_SHAPE),
        (ActorSpec(-10, 3.5), Face.FRONT | Face.RIGHT, View.L_SHAPE),
        (ActorSpec(150, 150), Face(0), View.NONE),
    ],
)
@pytest.mark.parametrize("noise", [EXACT, PLAIN], ids=["body", "box"])
def test_faces_and_view_follow_from_the_pose_of_the_car(actor, faces, view, noise):
    _, truth = scan(actor, noise=noise)
    assert Face(truth.faces[0]) == faces
    assert View(truth.view[0]) == view


@pytest.mark.parametrize("y", [4.0, 6.0, -6.0])
def test_wheels_and_guards_of_a_truck_abreast_do_not_count_as_its_ends(y):
    """Treads and the rear guard face forward, deep inside the outline; no unit sees an end of the truck."""
    _, truth = scan(ActorSpec(0.0, y, kind=Kind.TRUCK))
    assert Face(truth.faces[0]) == (Face.RIGHT if y > 0.0 else Face.LEFT)
    assert View(truth.view[0]) == View.SIDE


def test_mirrors_seen_from_behind_protrude_ahead_of_the_rear():
    """Sensor facts 4.1: 2.8 to 3.1 m ahead of the rear face and up to 0.2 m outside the width."""
    found = 0
    for gap in np.arange(14.0, 21.0, 0.5):
        car = ahead(gap)
        result, truth = scan(car)
        on_mirror = truth.part == Part.MIRROR
        found += on_mirror.sum()
        assert np.all(truth.cause[on_mirror] == Cause.MIRROR)
        from_rear = result.points_ego[on_mirror, 0] - (EGO_FRONT + gap)
        outside = np.abs(result.points_ego[on_mirror, 1]) - car.lwh[1] / 2
        assert np.all((from_rear > 2.8) & (from_rear < 3.2))
        assert np.all((outside > -0.02) & (outside < 0.2))
    assert found > 10


def test_points_well_inside_the_outline_are_layer_overlap():
    """From behind and 0.80 m above the ground, at 15 m, the top layer clears the deck and hits the rear window."""
    car = ahead(15.0)
    rig = replace(LUX_RIG, mounts=tuple(replace(mount, z_m=0.80) for mount in LUX_RIG.mounts))
    result, truth = scan(car, rig=rig, sensor=CENTRE_RAY)
    on_car = (truth.actor_id == 0) & (truth.part != Part.MIRROR)
    behind = result.points_ego[on_car, 0] - (car.x - car.lwh[0] / 2)
    overlap = truth.cause[on_car] == Cause.LAYER_OVERLAP
    assert np.any(overlap & np.isin(truth.part[on_car], [Part.GREENHOUSE, Part.INTERIOR]))
    bow = 0.25
    assert np.all(behind[overlap] > MAX_CLEAN_DEPTH)
    assert np.all(overlap[(behind > MAX_CLEAN_DEPTH + bow) & (np.abs(result.points_ego[on_car, 1]) < 0.6)])
    _, plain = scan(car, rig=rig, sensor=CENTRE_RAY, noise=PLAIN)
    assert np.all(plain.cause == Cause.CLEAN)


def test_points_off_actors_have_no_actor_id():
    _, truth = scan(ahead(10), obstacles=wall((20, -30), (20, 30)))
    elsewhere = (truth.part == Part.GROUND) | (truth.part == Part.OBSTACLE)
    assert elsewhere.any()
    assert np.array_equal(truth.actor_id == NO_ACTOR, elsewhere)
    assert np.all(truth.cause[elsewhere] == Cause.CLEAN)


def test_actor_ids_are_those_of_the_frame():
    _, truth = scan(ActorSpec(10, 4, id=7), ActorSpec(-12, -4, id=31))
    assert set(truth.actor_id[truth.part > Part.OBSTACLE]) == {7, 31}


def test_ray_that_ends_on_an_actor_gives_a_point_or_is_lost():
    """With one ray per beam; fails if hits are counted after the losses, or for another actor."""
    _, truth = scan(ActorSpec(10, 4, id=7), ActorSpec(-12, -4, id=31, paint=0.02), sensor=CENTRE_RAY)
    points = np.array([np.sum(truth.actor_id == actor) for actor in (7, 31)])
    assert np.all(truth.hits >= points)
    assert np.all(points > 0)
    assert truth.hits.sum() - points.sum() <= len(truth.lost_beam)
    assert truth.hits[1] > points[1]
