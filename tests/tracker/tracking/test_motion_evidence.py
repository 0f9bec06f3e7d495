"""Evidence of motion: vehicles are seen to move, walls that come into view are not."""

import math

import numpy as np
import pytest
from support.planar_scans import FAR_M, ranges, scan_of, sides

from luxloop.tracker.occupancy import Occupancy
from luxloop.tracker.records import MODELS, Status
from luxloop.tracker.tracking.motion_evidence import (
    INSET_M,
    MOVED_VIEWS_MIN,
    SPEED_MIN_MPS,
    MotionEvidence,
    face_places,
)
from luxloop.tracker.tracking.track_observation import TrackObservations
from luxloop.tracker.tracking.track_table import FACE_FRACTIONS, empty

DT = 0.08


def observed_face(table, whole):
    """Return the observation of a track by its visible part, from end to end or truncated along the heading."""
    one = np.ones((1, 2), dtype=np.bool_)
    return TrackObservations(
        row=np.zeros(1, dtype=np.int64),
        innovation=np.zeros((1, len(MODELS), 2)),
        covariance=np.eye(2)[None],
        heading=np.zeros(1),
        heading_variance=np.ones(1),
        size=table.visible_size.copy(),
        end_visible=one,
        untruncated=one & np.array([whole, True]),
        flat=one[:, 0],
        corner_sign=table.corner_sign.copy(),
        time_offset=np.zeros(1),
    )


def first_view_of_motion(scene, views=40, velocity=(8.0, 0.0), ego=(0.0, 0.0), whole=True, far=True, moved=False):
    """Return in which view a track is seen to move, 0 for none.

    `scene` returns, for a time [s], the segments of all objects, and x, y, length and width of the visible part of
    one along x [m], with the signs of its near corner. The ego moves with a velocity [m/s]. The visible part is
    `whole` from end to end; without `far` returns there is nothing but these objects. The object may have `moved`
    before it was hidden.
    """
    table, evidence = empty(MODELS, rows=1), MotionEvidence()
    table.status[0], table.moved_before_hidden[0] = int(Status.TENTATIVE), moved
    for k in range(views):
        at = np.array(ego) * k * DT
        segments, (x, y, length, width), sign = scene(k * DT)
        table.visible_size[0], table.corner_sign[0] = (length, width), sign
        table.estimate[0, :4] = x + 0.5 * sign[0] * length, y + 0.5 * sign[1] * width, *velocity
        seen = np.asarray(segments) - at
        keep = None if far else ranges(seen) < FAR_M
        scan = scan_of(seen, k * DT, (*at, 0.0), keep)
        evidence.observe(table, observed_face(table, whole), Occupancy.of(scan))
        if table.left[0]:
            return k + 1
    return 0


def crossing(speed, size=(4.5, 1.8)):
    """A vehicle that passes 15 m to the left."""

    def scene(time):
        x = -10.0 + speed * time
        return sides(x, 15.0, *size), (x, 15.0 - 0.5 * size[1], size[0], 0.1), (-1, -1)

    return scene


def ahead(speed, first=30.0):
    """A vehicle in the ego's lane, of which only the rear or the front is visible."""

    def scene(time):
        x = first + speed * time
        return sides(x, 0.0, 4.5, 1.8), (x - 2.25, 0.0, 0.1, 1.8), (-1, -1)

    return scene


@pytest.mark.parametrize(("speed", "views"), [(20.0, 8), (8.0, 10), (3.0, 20)])
def test_a_crossing_vehicle_is_seen_to_move(speed, views):
    """After four views with evidence; a vehicle at 8 m/s leaves its place in 0.3 s."""
    assert MOVED_VIEWS_MIN <= first_view_of_motion(crossing(speed), velocity=(speed, 0.0)) <= views


@pytest.mark.parametrize("speed", [-10.0, 10.0], ids=["approaching", "driving away"])
def test_a_vehicle_ahead_is_seen_to_move(speed):
    assert 0 < first_view_of_motion(ahead(speed), views=20, velocity=(speed, 0.0)) <= 12


def test_a_vehicle_that_keeps_its_distance_from_the_ego_is_seen_to_move():
    """It drives ahead of the ego at 10 m/s."""
    assert 0 < first_view_of_motion(ahead(10.0, first=20.0), ego=(10.0, 0.0), velocity=(10.0, 0.0)) <= 30


@pytest.mark.parametrize("ego", [(0.0, 0.0), (8.0, 0.0)], ids=["stationary", "moving"])
def test_a_stationary_vehicle_is_not_seen_to_move(ego):
    """Not even if its filter has a speed."""
    assert first_view_of_motion(crossing(0.0), ego=ego) == 0


@pytest.mark.parametrize("both", [False, True], ids=["uncovered by an occluder", "in a gap between two occluders"])
def test_a_wall_that_comes_into_view_is_not_seen_to_move(both):
    """Its visible part moves, or grows, at half of the occluder's 8 m/s or at all of it."""

    def scene(time):
        edge = -6.0 + 8.0 * time  # of the occluder's rear end, at half of the distance of the wall
        occluders = [*sides(edge + 20.0, 10.0, 40.0, 1.0), *(sides(edge - 22.5, 10.0, 40.0, 1.0) if both else [])]
        begin, end = 2.0 * (edge - 2.5) if both else -17.0, 2.0 * edge
        return [*sides(0.0, 20.0, 200.0, 0.2), *occluders], (0.5 * (begin + end), 19.9, end - begin, 0.1), (-1, -1)

    assert first_view_of_motion(scene) == 0


@pytest.mark.parametrize(("whole", "speed"), [(True, 10.0), (False, 10.0), (True, 0.0)])
def test_under_an_open_sky_a_whole_face_that_leaves_its_place_is_seen_to_move(whole, speed):
    """Beams that hit no object have no return, so that no place is free."""
    found = first_view_of_motion(crossing(speed), far=False, whole=whole, velocity=(10.0, 0.0))
    assert (found > 0) is (whole and speed > 0.0)
    assert not found or found <= 16


def test_a_bicycle_is_not_seen_to_move_as_a_vehicle():
    """A car end-on is as small along its motion, but wider."""
    assert first_view_of_motion(crossing(5.0, (1.7, 0.6)), velocity=(5.0, 0.0)) == 0
    assert first_view_of_motion(ahead(5.0, first=15.0), velocity=(5.0, 0.0)) > 0


def test_a_slow_object_is_not_seen_to_move():
    speed = SPEED_MIN_MPS - 0.1
    assert first_view_of_motion(crossing(speed), views=60, velocity=(speed, 0.0)) == 0


@pytest.mark.parametrize(("speed", "views"), [(8.0, MOVED_VIEWS_MIN), (1.0, 0)])
def test_of_a_vehicle_that_moved_before_it_was_hidden_the_speed_is_evidence_enough(speed, views):
    """Its places say nothing: it stands in the scans."""
    assert first_view_of_motion(crossing(0.0), velocity=(speed, 0.0), moved=True) == views


def test_evidence_counts_in_successive_views_only():
    """In every fourth scan something right before the unit hides the vehicle."""
    vehicle, views = crossing(20.0), iter(range(100))

    def scene(time):
        segments, visible, sign = vehicle(time)
        return [*segments, *(sides(0.0, 2.0, 60.0, 0.1) if next(views) % 4 == 3 else [])], visible, sign

    assert first_view_of_motion(scene, views=16, velocity=(20.0, 0.0)) == 0


@pytest.mark.parametrize("heading", [0.0, 0.6])
def test_places_are_on_the_visible_faces_behind_their_points(heading):
    """The near corner is the rear right one of a box of 4 by 2 m; the side has places at 0.8, 2 and 3.2 m from it."""
    turn = np.array([[math.cos(heading), -math.sin(heading)], [math.sin(heading), math.cos(heading)]])
    found = face_places(np.array([[10.0, 5.0]]), np.array([[-1, -1]]), np.array([heading]), np.array([[4.0, 2.0]]))[0]
    local = (found - [10.0, 5.0]) @ turn
    side = [[4.0 * f, INSET_M] for f in FACE_FRACTIONS]
    end = [[INSET_M, 2.0 * f] for f in FACE_FRACTIONS]
    np.testing.assert_allclose(local, [*side, *end], atol=1e-12)


def test_a_face_that_faces_away_has_no_places():
    found = face_places(np.zeros((1, 2)), np.array([[1, -1]]), np.zeros(1), np.array([[4.0, 0.3]]))[0]
    assert np.isnan(found[len(FACE_FRACTIONS) :]).all()
    assert np.isfinite(found[: len(FACE_FRACTIONS)]).all()
