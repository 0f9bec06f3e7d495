"""Occupancy of places, by hand and against brute force."""

from dataclasses import replace

import numpy as np
import pytest
from support.planar_scans import BEARINGS, ranges, scan_of, sides

from luxloop.tracker.free_space import BINS, UNIT_OFFSET_M
from luxloop.tracker.occupancy import (
    BEFORE_M,
    BEHIND_FRACTION,
    BEHIND_M,
    FREE,
    HIDDEN,
    NO_RETURN,
    OCCUPIED,
    PLACE_RADIUS_M,
    Occupancy,
)
from luxloop.tracker.scan import Scan

CAR = sides(20.0, 0.0, 4.0, 2.0)
"""Its rear is 18 m ahead."""


@pytest.mark.parametrize(
    ("place", "state"),
    [
        ((18.1, 0.0), OCCUPIED),  # the rear
        ((18.9, 0.0), HIDDEN),  # inside the car, hidden by its rear
        ((16.5, 0.0), OCCUPIED),  # less than a tenth of the range in front of it
        ((16.2, 0.0), FREE),
        ((18.1, 5.0), FREE),
        ((30.0, 0.0), HIDDEN),
        ((18.1, 1.2), OCCUPIED),  # 0.2 m beside a corner
        ((1.0, 0.0), NO_RETURN),  # within the ego
        ((np.nan, 0.0), NO_RETURN),
    ],
)
def test_places_about_a_car(place, state):
    assert Occupancy.of(scan_of(CAR)).states(np.array([place])).tolist() == [state]


def test_the_margins_are_those_of_the_definition():
    """Places on the axis, seen by beams along it: 18 m is 0.5 m nearer than 18.5 m, and a tenth behind 16.36 m. Within
    10 m, returns are 1 m behind."""
    occupancy = Occupancy.of(scan_of(CAR))
    states = {
        x: occupancy.states(np.array([[x, 0.0]])).item() for x in (18.0 + BEFORE_M - 0.01, 18.0 + BEFORE_M + 0.02)
    }
    assert list(states.values()) == [OCCUPIED, HIDDEN]
    far, near = 18.0 / (1.0 + BEHIND_FRACTION), 8.0 - BEHIND_M
    assert (far, near) == pytest.approx((16.3636, 7.0), abs=1e-4)
    assert occupancy.states(np.array([[far + 0.01, 0.0], [far - 0.02, 0.0]])).tolist() == [OCCUPIED, FREE]
    occupancy = Occupancy.of(scan_of(sides(10.0, 0.0, 4.0, 2.0)))
    assert occupancy.states(np.array([[near + 0.01, 0.0], [near - 0.02, 0.0]])).tolist() == [OCCUPIED, FREE]


def test_open_sky_says_nothing():
    """Beams without a return at the left: neither free nor occupied."""
    keep = np.abs(BEARINGS - 0.5 * np.pi) > 0.3
    left_and_right = np.array([[0.0, 20.0], [0.0, -20.0]])
    assert Occupancy.of(scan_of(CAR, keep=keep)).states(left_and_right).tolist() == [NO_RETURN, FREE]


def test_a_place_is_in_the_odometry_frame():
    pose = (100.0, -50.0, 0.5 * np.pi)
    ahead = np.array([[100.0, -50.0 + 18.1], [100.0 + 18.1, -50.0]])
    assert Occupancy.of(scan_of(CAR, pose=pose)).states(ahead).tolist() == [OCCUPIED, FREE]


def test_one_unit_sees_what_hides_a_place_from_another():
    """A pole 5 m ahead of the first unit hides the car; the second one, 3 m to the left, sees past it."""
    pole, units = sides(5.0, 0.0, 0.3, 0.3), np.array([[0.0, 0.0], [0.0, 3.0]])
    place = np.array([[18.1, 0.0]])
    points, unit = [], []
    for k, at in enumerate(units):
        distance = ranges([*CAR, *pole], at)
        x, y = distance * np.cos(BEARINGS) + at[0], distance * np.sin(BEARINGS) + at[1]
        points.append(np.stack([x, y, np.zeros_like(x)], axis=1))
        unit += [k] * len(BEARINGS)
    both = replace(Scan.from_points(0.0, np.concatenate(points), unit=unit), unit_positions_ego=units)
    first = replace(Scan.from_points(0.0, points[0]), unit_positions_ego=units[:1])
    assert Occupancy.of(first).states(place).tolist() == [HIDDEN]
    assert Occupancy.of(both).states(place).tolist() == [OCCUPIED]


def test_unknown_positions_of_units_widen_all_margins():
    """Within 2.5 m of a place, and a tenth of its range + 2.5 m behind it, nothing may be seen."""
    scan = replace(scan_of(CAR), unit_positions_ego=None)
    beside, before = 1.0 + UNIT_OFFSET_M + PLACE_RADIUS_M, (18.0 - UNIT_OFFSET_M) / (1.0 + BEHIND_FRACTION)
    places = np.array([[18.5, -beside + 0.3], [18.5, -beside - 0.6], [before + 0.1, 0.0], [before - 0.2, 0.0]])
    assert Occupancy.of(scan).states(places).tolist() == [OCCUPIED, FREE, OCCUPIED, FREE]


@pytest.mark.parametrize("seed", [0, 1])
def test_states_equal_brute_force(seed):
    rng = np.random.default_rng(seed)
    boxes = [sides(*rng.uniform(-30.0, 30.0, 2), *rng.uniform(0.5, 6.0, 2)) for _ in range(12)]
    occupancy, places = Occupancy.of(scan_of(np.concatenate(boxes))), rng.uniform(-40.0, 40.0, (400, 2))
    found = occupancy.states(places)
    width = 2.0 * np.pi / BINS
    expected = []
    for x, y in places:
        distance, half = np.hypot(x, y), np.arcsin(PLACE_RADIUS_M / max(np.hypot(x, y), PLACE_RADIUS_M))
        middle = np.arctan2(y, x)
        bins = np.arange(np.floor((middle - half) / width), np.floor((middle + half) / width) + 1).astype(int) % BINS
        seen = occupancy.nearest_m[0, bins]
        if distance <= 1.5:
            expected.append(NO_RETURN)
        elif (seen < distance - BEFORE_M).any():
            expected.append(HIDDEN)
        elif np.isfinite(seen).mean() < 0.5:
            expected.append(NO_RETURN)
        else:
            behind = distance + max(BEHIND_M, BEHIND_FRACTION * distance)
            expected.append(FREE if (seen[np.isfinite(seen)] > behind).all() else OCCUPIED)
    assert found.tolist() == expected
    assert {HIDDEN, FREE, OCCUPIED} <= set(expected)


def test_a_scan_without_points_shows_nothing():
    assert Occupancy.of(Scan.from_points(0.0, [])).states(np.array([[5.0, 0.0]])).tolist() == [NO_RETURN]
