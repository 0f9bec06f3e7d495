"""Numbers, paint, and who is in a frame."""

import numpy as np
import pytest

from sim.cast import Cast, frame_around_ego
from sim.kinematics import Rates
from sim.paint import SHADES, paint_reflectivity
from sim.world import Kind

SIZE = (4.7, 1.8, 1.5)


def test_numbers_go_by_appearance_and_stay():
    cast = Cast(seed=1)
    assert cast.find("b") is None
    assert [cast.enter(key, Kind.CAR, SIZE).id for key in ("b", "a")] == [0, 1]
    assert cast.find("b").id == 0
    assert cast.find("a").name == "car.1"


def test_paint_depends_on_seed_and_number_alone():
    alone = Cast(seed=3).enter("x", Kind.CAR, SIZE)
    crowded = Cast(seed=3)
    assert crowded.enter("y", Kind.BUS, SIZE).reflectivity == alone.reflectivity
    assert crowded.enter("z", Kind.CAR, SIZE, reflectivity=0.9).reflectivity == 0.9
    assert paint_reflectivity(4, 0) != alone.reflectivity


def test_paint_comes_in_the_shares_of_its_shades():
    draws = np.array([paint_reflectivity(11, number) for number in range(2000)])
    assert sum(share for share, _, _ in SHADES) == pytest.approx(1.0)
    for share, low, high in SHADES:
        # four standard deviations of a binomial share
        assert np.mean((draws >= low) & (draws <= high)) == pytest.approx(share, abs=4 * (share / 2000) ** 0.5)


def test_a_frame_holds_the_ego_apart_and_others_up_to_the_range():
    cast = Cast(seed=0)
    members = [cast.enter(key, Kind.CAR, SIZE, key) for key in ("ego", "near", "edge", "far")]
    pose = np.array([[10.0, 0, 0], [10, 5, 1], [40, 0, 2], [40.1, 0, 3]])
    rates = Rates(velocity_world=pose[:, :2] + 0.5, acceleration_world=pose[:, :2] + 0.7, yaw_rate=pose[:, 2] + 0.1)
    frame = frame_around_ego(25, 0.08, members, pose, rates, range_m=30.0)
    assert (frame.index, frame.time) == (25, pytest.approx(2.0))
    assert list(frame.actors.name) == ["near", "edge"]
    assert frame.ego.velocity_world == pytest.approx([10.5, 0.5])
    assert frame.ego.yaw_rate == pytest.approx(0.1)
    assert frame.actors.acceleration_world == pytest.approx(pose[1:3, :2] + 0.7)


def test_an_empty_road_has_arrays_of_the_right_shape():
    cast = Cast(seed=0)
    pose = np.zeros((1, 3))
    rates = Rates(np.zeros((1, 2)), np.zeros((1, 2)), np.zeros(1))
    actors = frame_around_ego(0, 0.08, [cast.enter("ego", Kind.CAR, SIZE)], pose, rates, 30.0).actors
    assert len(actors) == 0
    assert (actors.size.shape, actors.pose_world.shape, actors.name.dtype.kind) == ((0, 3), (0, 3), "U")
