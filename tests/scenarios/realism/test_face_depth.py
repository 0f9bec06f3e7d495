"""Visible faces and depths of points set by hand."""

import numpy as np
import pytest
from support.labelled_shapes import ABREAST, BEHIND, SIZE, left, rear, vehicle

from luxloop.scenarios.realism.vehicle_figures import least_depth, visible_faces


def ends(faces):
    return [face.end for face in faces]


@pytest.mark.parametrize(
    ("lidars", "expected"),
    [
        ([BEHIND], [True]),
        ([ABREAST], [False]),
        ([(-20.0, 5.0)], [True, False]),
        ([(-20.0, 0.89)], [True]),  # not in front of the flank's plane, 0.90 m from the axis
        ([(-20.0, 0.91)], [True, False]),
        ([BEHIND, ABREAST], [True, False]),  # a unit behind, another abreast
    ],
)
def test_a_face_is_visible_if_a_lidar_is_in_front_of_its_plane(lidars, expected):
    assert ends(visible_faces(vehicle(rear(0.0, [0.0]), lidars=lidars))) == expected


def test_depth_counts_from_the_tenth_percentile_of_the_near_points():
    """Depths 0.20 to 0.30 in steps of 1 cm: their 10th percentile is 0.21."""
    depth = np.linspace(0.20, 0.30, 11)
    (face,) = visible_faces(vehicle(rear(depth, np.linspace(-0.5, 0.5, 11))))
    np.testing.assert_allclose(face.depth, depth - 0.21, atol=1e-12)
    np.testing.assert_allclose(face.along, np.linspace(-0.5, 0.5, 11))


def test_an_offset_of_the_label_changes_no_depth():
    depth, along = np.linspace(0.0, 0.3, 13), np.linspace(-0.6, 0.6, 13)
    here, there = (visible_faces(vehicle(rear(depth + shift, along)))[0].depth for shift in (0.0, 0.12))
    np.testing.assert_allclose(here, there, atol=1e-12)


@pytest.mark.parametrize(
    ("depth", "along"),
    [
        (np.full(4, 0.2), np.linspace(-0.3, 0.3, 4)),  # four points are too few
        (np.full(9, 0.7), np.linspace(-0.3, 0.3, 9)),  # deeper than 60 cm
        (np.full(9, 0.2), np.full(9, 0.5 * SIZE[1] - 0.24)),  # within 25 cm of the face's end
    ],
)
def test_a_face_without_enough_near_points_stays_at_the_label(depth, along):
    (face,) = visible_faces(vehicle(rear(depth, along)))
    np.testing.assert_allclose(face.depth, depth, atol=1e-12)


def test_depth_of_a_vehicle_is_the_smaller_over_its_faces():
    """A point on the flank is metres behind the rear, but not inside."""
    points = np.concatenate([rear(0.0, np.linspace(-0.6, 0.6, 9)), left(0.0, np.linspace(-1.0, 1.0, 9)), [(0.0, 0.4)]])
    depth = least_depth(visible_faces(vehicle(points, lidars=[(-20.0, 10.0)])))
    np.testing.assert_allclose(depth[:-1], 0.0, atol=1e-12)
    assert depth[-1] == pytest.approx(0.5)  # 0.9 - 0.4 behind the flank, 2.2 behind the rear


def test_depths_do_not_depend_on_the_pose_of_the_vehicle():
    points = rear(np.linspace(0.0, 0.2, 9), np.linspace(-0.6, 0.6, 9))
    here, there = (visible_faces(vehicle(points, pose=pose))[0] for pose in [(0, 0, 0), (12.0, -7.0, 2.1)])
    np.testing.assert_allclose(here.depth, there.depth, atol=1e-12)
    np.testing.assert_allclose(here.along, there.along, atol=1e-12)
