"""Time to collision of two boxes: cases by hand, and small steps with shapely polygons."""

import numpy as np
import pytest
import shapely
from shapely import affinity

from luxloop.scenarios.grading.emergence import time_to_collision

CAR = (4.0, 2.0)


def of(a, velocity_a, b, velocity_b):
    return time_to_collision(*(np.array([row], dtype=float) for row in (a, velocity_a, b, velocity_b)))[0]


@pytest.mark.parametrize(
    ("a", "velocity_a", "b", "velocity_b", "expected"),
    [
        # Bumper to bumper: 20 m between the centres, 16 m between the boxes, closing with 8 m/s.
        ((0, 0, 0, *CAR), (10, 0), (20, 0, 0, *CAR), (2, 0), 2.0),
        # The same, opening.
        ((0, 0, 0, *CAR), (2, 0), (20, 0, 0, *CAR), (10, 0), np.inf),
        # Side by side in lanes 3.5 m apart: never.
        ((0, 0, 0, *CAR), (10, 0), (20, 3.5, 0, *CAR), (2, 0), np.inf),
        # Already overlapping, both standing.
        ((0, 0, 0, *CAR), (0, 0), (3.5, 0.5, 0, *CAR), (0, 0), 0.0),
        # Crossing: b's front is 7 m from a's side (10 - 1 - 2) after 0.7 s at 10 m/s; a, which stands, is in the way.
        ((0, 0, 0, *CAR), (0, 0), (0, -10, np.pi / 2, *CAR), (0, 10), 0.7),
        # Crossing behind a: a has left before b arrives.
        ((0, 0, 0, *CAR), (20, 0), (0, -10, np.pi / 2, *CAR), (0, 10), np.inf),
    ],
)
def test_cases_by_hand(a, velocity_a, b, velocity_b, expected):
    assert of(a, velocity_a, b, velocity_b) == pytest.approx(expected)
    assert of(b, velocity_b, a, velocity_a) == pytest.approx(expected)


def test_it_equals_small_steps_of_polygons():
    draw = np.random.default_rng(3)
    boxes = [random_boxes(draw) for _ in "ab"]
    speeds = [draw.uniform(-6, 6, (40, 2)) for _ in "ab"]
    found = time_to_collision(boxes[0], speeds[0], boxes[1], speeds[1])
    assert 10 < np.isfinite(found).sum() < 40
    for row, time in enumerate(found):
        assert stepped(boxes[0][row], boxes[1][row], speeds[1][row] - speeds[0][row]) == pytest.approx(time, abs=0.011)


def stepped(a, b, velocity, step_s=0.01):
    still, moving = polygon(*a), polygon(*b)
    for step in range(1000):
        if still.intersects(affinity.translate(moving, *(velocity * step * step_s))):
            return step * step_s
    return np.inf


def polygon(x, y, yaw, length, width):
    upright = shapely.box(-0.5 * length, -0.5 * width, 0.5 * length, 0.5 * width)
    return affinity.translate(affinity.rotate(upright, yaw, origin=(0, 0), use_radians=True), x, y)


def random_boxes(draw, n=40):
    return np.column_stack([draw.uniform(-8, 8, (n, 2)), draw.uniform(-3, 3, n), draw.uniform(0.5, 6, (n, 2))])


def test_equal_speeds_with_a_rounding_error_never_meet():
    """Two cars in a lane at the same speed: a difference of 1e-14 m/s is a time of 1e15 s, which no table holds."""
    cars = np.array([[0.0, 0.0, 0.3, 4.5, 1.8], [20.0, 6.0, 0.3, 4.5, 1.8]])
    velocity = 25.0 * np.array([[np.cos(0.3), np.sin(0.3)]])
    time = time_to_collision(cars[:1], velocity * (1.0 + 1e-15), cars[1:], velocity)
    assert np.isinf(time).all()
