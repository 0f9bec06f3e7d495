"""World frames from members and their motion: selection by range, and correct assignment of values."""

import numpy as np
import pytest

from luxloop.sim.frame_builder import FrameBuilder
from luxloop.sim.kinematics import Kinematics
from luxloop.sim.modes import ModeLimits
from luxloop.sim.roster import Roster
from luxloop.sim.world import Kind, Mode

DT = 0.08
SIZE = (4.7, 1.8, 1.5)


def motion(pose):
    """Return a motion with a distinct value in each field."""
    pose = np.asarray(pose, dtype=np.float64)
    return Kinematics(
        pose_world=pose,
        velocity_world=pose[:, :2] + 0.5,
        acceleration_world=pose[:, :2] + 0.7,
        yaw_rate=pose[:, 2] + 0.1,
        articulation=pose[:, 2] + 0.2,
        changes_lane=pose[:, 0] == 40.0,
        deviation=pose[:, :2] + 0.3,
    )


def test_a_frame_has_the_ego_and_the_actors_in_range():
    roster = Roster(seed=0)
    names = ("ego", "near", "far", "edge")
    members = [roster.add(key, Kind.CAR, (4.0 + n, 1.8, 1.5), key) for n, key in enumerate(names)]
    pose = np.array([[10.0, 0, 0], [10, 5, 1], [40.1, 0, 2], [40, 0, 3]])
    seen = [1, 3]
    frame = FrameBuilder(DT, 30.0, ModeLimits()).frame(members, motion(pose))
    ego, actors = frame.ego, frame.actors
    assert list(actors.name) == ["near", "edge"]
    assert list(actors.id) == seen
    assert (ego.velocity_world.tolist(), ego.acceleration_world.tolist()) == ([10.5, 0.5], [10.7, 0.7])
    assert (ego.yaw_rate, ego.deviation.tolist(), ego.size.tolist()) == (0.1, [10.3, 0.3], [4.0, 1.8, 1.5])
    assert actors.pose_world == pytest.approx(pose[seen])
    assert actors.velocity_world == pytest.approx(pose[seen, :2] + 0.5)
    assert actors.acceleration_world == pytest.approx(pose[seen, :2] + 0.7)
    assert actors.yaw_rate == pytest.approx([1.1, 3.1])
    assert actors.articulation == pytest.approx([1.2, 3.2])
    assert actors.deviation == pytest.approx(pose[seen, :2] + 0.3)
    assert actors.size[:, 0].tolist() == [5.0, 7.0]
    assert actors.changes_lane.tolist() == [False, True]
    assert actors.reflectivity.tolist() == [member.reflectivity for member in (members[1], members[3])]


def test_frames_are_counted_and_modes_have_hysteresis():
    roster = Roster(seed=0)
    members = [roster.add(key, Kind.CAR, SIZE) for key in ("ego", "a")]
    frame_builder = FrameBuilder(DT, 30.0, ModeLimits())
    frames = []
    for speed in (5.0, 0.35, 0.2, 0.45):
        still = motion(np.zeros((2, 3)))
        still.velocity_world[:] = (0.0, speed)
        still.acceleration_world[:] = 0.0
        frames.append(frame_builder.frame(members, still))
    assert [frame.index for frame in frames] == [0, 1, 2, 3]
    assert [frame.time for frame in frames] == [0.0, DT, 2 * DT, 3 * DT]
    modes = [Mode(frame.actors.mode[0]) for frame in frames]
    assert modes == [Mode.CONSTANT_VELOCITY, Mode.CONSTANT_VELOCITY, Mode.STATIONARY, Mode.STATIONARY]


def test_an_empty_road_has_arrays_of_the_correct_shape():
    ego = Roster(seed=0).add("ego", Kind.CAR, SIZE)
    actors = FrameBuilder(DT, 30.0, ModeLimits()).frame([ego], motion(np.zeros((1, 3)))).actors
    assert len(actors) == 0
    assert (actors.size.shape, actors.pose_world.shape, actors.mode.shape) == ((0, 3), (0, 3), (0,))
    assert (actors.name.dtype.kind, actors.mode.dtype, actors.changes_lane.dtype) == ("U", np.uint8, np.bool_)


def test_an_actor_that_comes_as_another_one_leaves_has_its_own_columns():
    """Fails if the number of actors decides whether they are the same."""
    roster = Roster(seed=0)
    specs = (("ego", Kind.CAR, SIZE), ("car", Kind.CAR, SIZE), ("bus", Kind.BUS, (12.0, 2.5, 3.0)))
    ego, car, bus = (roster.add(key, kind, size, key) for key, kind, size in specs)
    frame_builder, pose = FrameBuilder(DT, 30.0, ModeLimits()), motion([[0.0, 0, 0], [10, 0, 0]])
    for number, other in ((1, car), (2, bus), (1, car)):
        actors = frame_builder.frame([ego, other], pose).actors
        assert (actors.id.tolist(), actors.name.tolist()) == ([number], [other.name])
        assert (actors.kind.tolist(), actors.size.tolist()) == ([other.kind], [list(other.size)])
        assert actors.reflectivity.tolist() == [other.reflectivity]
