"""Warnings of recordings that contradict themselves: circles and straight drives made by hand."""

import csv

import numpy as np

from luxloop.sim.replay.recording import Recording, RoadUser
from luxloop.sim.replay.recording_checks import contradictions
from luxloop.sim.replay.replay_config import ReplayTraffic
from luxloop.sim.replay.replay_source import ReplaySource
from luxloop.sim.replay.trajectories import Trajectories
from luxloop.sim.world import Kind

TIME = np.arange(0.0, 10.0, 0.1)


def circle(yaw):
    """Return x, y and yaw at 5 m/s on a circle of 20 m."""
    angle = 0.25 * TIME
    return np.column_stack(
        [20.0 * np.sin(angle), 20.0 - 20.0 * np.cos(angle), angle if yaw is None else np.full(100, yaw)]
    )


def shuttle(yaw):
    """Return the same at 5 m/s along x, backwards after 5 s."""
    x = 5.0 * np.minimum(TIME, 10.0 - TIME)
    return np.column_stack([x, np.zeros(100), np.full(100, yaw)])


def warned(*poses, kind=Kind.CAR):
    users = [RoadUser(f"n{row}", kind, (4.0, 1.8, 1.5)) for row in range(len(poses))]
    user = np.repeat(np.arange(len(poses)), len(TIME))
    recording = Recording(users, user, np.tile(TIME, len(poses)), np.concatenate(poses))
    return contradictions(recording, Trajectories.of(recording, gap_s=1.0))


def write_table(path, poses_by_id):
    with path.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["time_s", "id", "x_m", "y_m", "yaw_deg"])
        for name, poses in poses_by_id.items():
            rows.writerows([t, name, x, y, np.degrees(yaw)] for t, (x, y, yaw) in zip(TIME, poses, strict=True))


def test_a_constant_heading_on_a_circle_is_named():
    (warning,) = warned(circle(None), circle(0.0))
    assert warning.startswith('"n1" head more than 45 degrees away from their course')
    assert warned(circle(0.0), kind=Kind.PEDESTRIAN) == ()


def test_reversing_needs_a_heading():
    assert warned(shuttle(0.0), shuttle(np.pi)) == ()
    (warning,) = warned(shuttle(np.nan), shuttle(0.0))
    assert warning == '"n0" turn on the spot; give headings of those that reverse'


def test_driving_backwards_fast_is_a_wrong_heading():
    (warning,) = warned(np.column_stack([10.0 * TIME, 0.0 * TIME, np.full(100, np.pi)]), shuttle(0.0))
    assert warning.startswith('"n0" drive backwards at more than 8 m/s by their headings')


def test_the_truth_reverses_as_the_table_does(tmp_path):
    """3 m/s forwards, slower, and backwards in a bend; without headings the car would turn around."""
    angle = 3.0 * 8.0 / np.pi * np.sin(np.pi * TIME / 8.0) / 15.0
    poses = np.column_stack([15.0 * np.sin(angle), 15.0 - 15.0 * np.cos(angle), angle])
    write_table(tmp_path / "a.csv", {"ego": np.tile([-20.0, 0.0, 0.0], (len(TIME), 1)), "car": poses})
    source = ReplaySource(ReplayTraffic(file="a.csv", ego="ego"), tmp_path, 100.0)
    source.reset(1)
    assert source.warnings == ()
    slowest = 0.0
    for _ in range(110):
        frame = source.step()
        expected = [np.interp(frame.time, TIME, column) for column in poses.T]
        pose = frame.actors.pose_world[0] + [*source.origin, 0.0]
        assert np.allclose(pose, expected, atol=0.1)
        ahead = frame.actors.velocity_world[0] @ [np.cos(pose[2]), np.sin(pose[2])]
        slowest = min(slowest, ahead)
    assert slowest < -2.5


def test_the_source_hands_the_warnings_on(tmp_path):
    write_table(tmp_path / "a.csv", {"7": circle(0.0)})
    source = ReplaySource(ReplayTraffic(file="a.csv", ego="7"), tmp_path, 100.0)
    source.reset(1)
    assert source.warnings[0].startswith('a.csv: "7" head more than 45 degrees away from their course')
