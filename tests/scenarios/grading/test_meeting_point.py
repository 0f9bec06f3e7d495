"""Meeting points of straight, crossing and merging paths by hand."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from luxloop.scenarios.grading.emergence import AHEAD_S, EgoPath

TIME_S = np.arange(60) * 0.1


def path(speed_mps=10.0):
    """Path of an ego of 4 m by 2 m that starts at x = 0 along x; its front starts at 2 m."""
    boxes = np.zeros((60, 5))
    boxes[:, 0], boxes[:, 3:] = speed_mps * TIME_S, (4.0, 2.0)
    return EgoPath.of(TIME_S, boxes)


def straight(x, y, yaw, speed_mps, size=(4.0, 1.6), frames=60):
    boxes = np.zeros((frames, 5))
    boxes[:, 0] = x + speed_mps * math.cos(yaw) * TIME_S[:frames]
    boxes[:, 1] = y + speed_mps * math.sin(yaw) * TIME_S[:frames]
    boxes[:, 2], boxes[:, 3:] = yaw, size
    return boxes


def test_paths_that_cross_meet_half_the_widths_before_the_crossing():
    # The actor's path is x = 30; half the widths are 1 + 0.8 m, so the front meets it at 28.2 m: 26.2 m from its start.
    time_s, along_m = path().meeting(straight(30.0, -20.0, math.pi / 2, 5.0), 5.0)
    assert (time_s, along_m) == pytest.approx((2.62, 26.2))


def test_the_time_of_the_actor_does_not_matter():
    early, late = (path().meeting(straight(30.0, y, math.pi / 2, 10.0), 10.0) for y in (-10.0, -50.0))
    assert early == pytest.approx(late)


def test_a_path_continues_for_a_second_beyond_the_end_of_the_run():
    # After 1.9 s the actor's front is at -20 + 9.5 + 2 = -8.5 m; 5 m ahead of that it still is 3.5 m off, 1.7 too far.
    assert np.isnan(path().meeting(straight(30.0, -20.0, math.pi / 2, 5.0, frames=20), 5.0)).all()
    # At 10 m/s its front ends at 0.9 m; straight ahead from there it is across the ego's path.
    assert path().meeting(straight(30.0, -20.0, math.pi / 2, 10.0, frames=20), 10.0)[1] == pytest.approx(26.2)


@pytest.mark.parametrize(
    "boxes",
    [
        straight(10.0, 3.5, 0.0, 5.0),  # the next lane: 3.5 m is more than 1.8 m
        straight(-10.0, 0.0, 0.0, 12.0),  # a follower: the ego has been in its path from the first frame on
        straight(200.0, -20.0, math.pi / 2, 5.0),  # beyond the end of the run
    ],
)
def test_paths_that_do_not_meet(boxes):
    assert np.isnan(path().meeting(boxes, 5.0)).all()


def test_the_path_of_a_standing_actor_is_its_length():
    # Its rear is at 30 - 2 = 28 m; the front comes within 1.8 m of it at 26.2 m, 24.2 m from the start.
    assert path().meeting(straight(30.0, 0.0, 0.0, 0.0), 0.0)[1] == pytest.approx(24.2)


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 4.0, 9.0]))
def test_the_first_near_point_is_that_of_shapely(seed, speed_mps):
    """Winding paths; both lie on the boundary of the actor's path, widened by half of both widths."""
    rng = np.random.default_rng(seed)
    yaw = rng.uniform(-np.pi, np.pi) + np.cumsum(rng.normal(0.0, 0.05, 60))
    boxes = straight(rng.uniform(5.0, 50.0), rng.uniform(-25.0, 25.0), 0.0, 0.0)
    boxes[:, 2] = yaw
    boxes[1:, :2] += np.cumsum(0.1 * speed_mps * np.column_stack([np.cos(yaw), np.sin(yaw)]), axis=0)[:-1]
    heading = np.column_stack([np.cos(yaw), np.sin(yaw)])
    ends = boxes[0, :2] - 2.0 * heading[0], boxes[-1, :2] + (2.0 + AHEAD_S * speed_mps) * heading[-1]
    line, ego = shapely.LineString([ends[0], *boxes[:, :2], ends[1]]), path()
    distance_m = shapely.distance(line, shapely.points(ego.front))
    near = np.flatnonzero(distance_m <= 1.8)
    along_m = ego.meeting(boxes, speed_mps)[1]
    if not len(near) or near[0] == 0:
        assert np.isnan(along_m)
    else:
        expected = np.interp(-1.8, -distance_m[near[0] - 1 : near[0] + 1], ego.along_m[near[0] - 1 : near[0] + 1])
        assert along_m == pytest.approx(expected, abs=1e-9)
