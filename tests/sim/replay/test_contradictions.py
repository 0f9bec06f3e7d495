"""Warnings of recordings that contradict themselves: circles and straight drives made by hand."""

import csv

import numpy as np

from luxloop.sim.replay.contradictions import contradictions
from luxloop.sim.replay.recording import Recording, RoadUser
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


def test_a_constant_heading_on_a_circle_is_named():
    (warning,) = warned(circle(None), circle(0.0))
    assert warning.startswith('"n1" head more than 45 degrees away from their course')
    assert warned(circle(0.0), kind=Kind.PEDESTRIAN) == ()


def test_reversing_needs_a_heading():
    assert warned(shuttle(0.0), shuttle(np.pi)) == ()
    (warning,) = warned(shuttle(np.nan), shuttle(0.0))
    assert warning == '"n0" turn on the spot; give headings of those that reverse'


def test_the_source_hands_the_warnings_on(tmp_path):
    with (tmp_path / "a.csv").open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["time_s", "id", "x_m", "y_m", "yaw_deg"])
        rows.writerows([time, 7, x, y, 0.0] for time, (x, y, _) in zip(TIME, circle(0.0), strict=True))
    source = ReplaySource(ReplayTraffic(file="a.csv", ego="7"), tmp_path, 100.0)
    source.reset(1)
    assert source.warnings[0].startswith('a.csv: "7" head more than 45 degrees away from their course')
