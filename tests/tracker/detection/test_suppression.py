import numpy as np
import pytest

from luxloop.tracker.detection.boxes import in_shadow, nearest_corner
from luxloop.tracker.records import Boxes


def boxes(*rectangles):
    """Boxes (x, y, heading, along, across) in the ego frame."""
    x, y, heading, along, across = np.array(rectangles, dtype=float).T
    center, size = np.stack([x, y], axis=1), np.stack([along, across], axis=1)
    corner, sign = nearest_corner(center, heading, size)
    count = len(x)
    return Boxes(
        segment=np.arange(count),
        center_ego=center,
        heading=heading,
        size=size,
        corner_ego=corner,
        corner_sign=sign,
        covariance=np.tile(np.eye(3), (count, 1, 1)),
        support=np.full(count, 20),
        time_offset=np.zeros(count),
        cut=np.zeros((count, 2, 2), dtype=np.bool_),
        flat=np.zeros(count, dtype=np.bool_),
        viewpoint_ego=np.zeros((count, 2)),
    )


FRONT = (-20.0, 0.0, 0.0, 0.1, 1.7)  # a car that follows: only its front is seen


@pytest.mark.parametrize("heading", [0.0, np.pi / 2])
def test_a_windscreen_behind_a_hood_is_suppressed(heading):
    front = FRONT if heading == 0.0 else (-20.0, 0.0, heading, 1.7, 0.1)
    windscreen = (-21.6, 0.1, 0.0, 0.2, 1.2)
    assert in_shadow(boxes(front, windscreen)).tolist() == [False, True]


@pytest.mark.parametrize(
    "other",
    [
        (-26.5, 0.0, 0.0, 0.1, 1.7),  # the next car of the queue
        (-21.6, 3.5, 0.0, 4.5, 0.1),  # the next lane
        (-18.5, 0.0, 0.0, 0.1, 1.7),  # nearer than the front itself
    ],
)
def test_other_vehicles_are_not_suppressed(other):
    assert not in_shadow(boxes(FRONT, other))[1]


def test_a_box_inside_a_nearer_one_is_suppressed_and_one_behind_it_is_not():
    whole, inner, behind = (12.0, 4.0, 0.0, 4.5, 1.8), (12.5, 4.2, 0.0, 1.0, 0.6), (16.0, 4.3, 0.0, 0.1, 1.5)
    assert in_shadow(boxes(whole, inner, behind)).tolist() == [False, True, False]


def test_no_boxes():
    assert in_shadow(boxes(FRONT).subset(np.zeros(0, dtype=np.int64))).shape == (0,)
