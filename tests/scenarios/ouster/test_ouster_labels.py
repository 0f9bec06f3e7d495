"""Labels of the cars in the Ouster recordings: consistency of the files, without the recordings."""

import csv

import numpy as np
import pytest
from twin.labels import CLASSES, LABELS, Car, load_cars, load_views
from twin.pairs import on_car

CARS, VIEWS = load_cars(), load_views()
SIZES = {
    # length, width, height [m]
    "small car": ((3.5, 4.5), (1.6, 1.85), (1.25, 1.6)),
    "sedan": ((4.0, 5.1), (1.7, 1.95), (1.25, 1.65)),
    "SUV": ((4.2, 5.1), (1.8, 2.05), (1.6, 1.95)),
    "van": ((4.6, 7.0), (1.8, 2.2), (1.7, 2.9)),
    "pickup": ((5.0, 6.2), (1.8, 2.1), (1.65, 2.0)),
    "truck": ((6.0, 12.0), (2.1, 2.6), (2.4, 4.0)),
}


def corners(car):
    """Return the (4, 2) corners of a label, and the (2, 2) directions of its sides."""
    heading = np.deg2rad(car.heading_deg)
    axes = np.array([[np.cos(heading), np.sin(heading)], [-np.sin(heading), np.cos(heading)]])
    half = 0.5 * np.array([car.length_m, car.width_m])
    signs = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)])
    return np.array([car.x_m, car.y_m]) + (signs * half) @ axes, axes


def overlap(one, other):
    """Return whether two boxes overlap, by separating axes."""
    (a, axes_a), (b, axes_b) = corners(one), corners(other)
    for axis in (*axes_a, *axes_b):
        if (a @ axis).max() < (b @ axis).min() or (b @ axis).max() < (a @ axis).min():
            return False
    return True


def test_there_are_enough_unobstructed_cars():
    assert sum(car.unobstructed for car in CARS) >= 25
    assert len({car.id for car in CARS}) == len(CARS)
    assert {car.category for car in CARS} <= set(CLASSES)


def test_every_car_belongs_to_a_view():
    views = {(view.recording, view.frame) for view in VIEWS}
    assert {(car.recording, car.frame) for car in CARS} == views


@pytest.mark.parametrize("car", CARS, ids=lambda car: car.id)
def test_size_and_uncertainty_suit_the_class(car):
    for value, (low, high) in zip((car.length_m, car.width_m, car.height_m), SIZES[car.category], strict=True):
        assert low <= value <= high
    assert car.range_m <= 40.0
    assert 0.3 <= car.heading_sigma_deg <= 3.0
    assert 0.05 <= car.position_sigma_m <= 0.3
    assert np.isnan(car.reflectivity) or 0.0 < car.reflectivity <= 1.0


@pytest.mark.parametrize("car", CARS, ids=lambda car: car.id)
def test_seen_faces_are_turned_to_the_sensor(car):
    ahead, left, _ = car.in_box(np.zeros((1, 3)))[0]
    assert car.end_seen or car.side_seen
    if car.side_seen:
        assert (left > 0) == (car.side_seen == "left")
        assert abs(left) > car.width_m / 2
    if car.end_seen:
        assert (ahead > 0) == (car.end_seen == "front")
        assert abs(ahead) > car.length_m / 2


def test_labels_of_one_frame_do_not_overlap():
    for i, one in enumerate(CARS):
        for other in CARS[:i]:
            assert one.recording != other.recording or not overlap(one, other), (one.id, other.id)


def test_frame_of_a_car():
    """A car 10 m ahead, turned left by 90 degrees: its left is away from the sensor."""
    seen = ("", "right", True, True, True)
    car = Car("x", "r", 0, "sedan", 10.0, 0.0, 0.2, 90.0, 4.0, 2.0, 1.5, *seen, 1.0, 0.1, np.nan)
    np.testing.assert_allclose(car.in_box(np.array([[9.0, 1.5, 1.0]])), [[1.5, 1.0, 0.8]], atol=1e-12)
    points = np.array([[9.0, 2.1, 1.0], [9.0, 2.2, 1.0], [8.9, 0.0, 0.34], [10.0, 0.0, 1.95]])
    assert on_car(points, car).tolist() == [True, False, False, False]


def test_files_have_no_empty_cells_but_reflectivities():
    with (LABELS / "cars.csv").open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            assert all(value for key, value in row.items() if key != "reflectivity")
