"""Walls with vehicles chained to them, and the memory of walls, in scans of a flat world with known surfaces."""

import math

import numpy as np
import pytest

from luxloop.tracker.detection.background import Background, BackgroundConfig
from luxloop.tracker.detection.lidar import LidarConfig
from luxloop.tracker.detection.point_groups import any_within
from luxloop.tracker.detection.segmentation import SegmentationConfig, segment
from luxloop.tracker.detection.walls import straight_runs
from luxloop.tracker.records import NOT_USED

BEAM = np.radians(0.25)
NOISE_M = 0.02


def car(x, y, length=4.6, width=1.8):
    """Outline (4, 2) of a vehicle centred on x, y, parallel to x."""
    return np.array([x, y]) + 0.5 * np.array([[length, width], [-length, width], [-length, -width], [length, -width]])


def house(low, high):
    (x0, y0), (x1, y1) = low, high
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], dtype=float)


def scan_of(*outlines, seed=0):
    """Return the nearest points (N, 2) on closed outlines (K, 2) from the origin, and the outline (N,) of each."""
    angle = np.arange(0.0, 2 * np.pi, BEAM)
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    nearest, owner = np.full(len(ray), np.inf), np.full(len(ray), -1)
    for number, outline in enumerate(outlines):
        for start, end in zip(outline, np.roll(outline, -1, axis=0), strict=True):
            side = end - start
            across = ray[:, 0] * side[1] - ray[:, 1] * side[0]
            with np.errstate(divide="ignore", invalid="ignore"):
                distance = (start[0] * side[1] - start[1] * side[0]) / across
                share = (start[0] * ray[:, 1] - start[1] * ray[:, 0]) / across
            hit = (distance > 0) & (share >= 0) & (share <= 1) & (distance < nearest)
            nearest[hit], owner[hit] = distance[hit], number
    seen = nearest < 50.0
    noise = np.random.default_rng(seed).normal(0.0, NOISE_M, seen.sum())
    return (nearest[seen] + noise)[:, None] * ray[seen], owner[seen]


def shares(left, owner, count):
    """(count,) share of each outline's points that are left."""
    return [float(np.mean(left.label[owner == number] != NOT_USED)) for number in range(count)]


class Drive:
    """A stationary ego that looks at one scene after another."""

    def __init__(self):
        self.background, self.time, self.frame = Background(BackgroundConfig()), 0.0, 0

    def see(self, *outlines, scans=1):
        """Return the share of points left of each outline, and the last segments with the owners of their points."""
        for _ in range(scans):
            self.frame += 1
            self.time += 0.08
            points, owner = scan_of(*outlines, seed=self.frame)
            segments = segment(points, np.ones(len(points), np.bool_), SegmentationConfig())
            self.background.forget(self.time, points)
            left = self.background.remove(points, segments)
        return shares(left, owner, len(outlines)), left, owner


WALL = house((-20.0, 8.0), (32.0, 9.0))


@pytest.mark.parametrize("gap", [0.35, 0.5])
def test_a_car_parked_beside_a_wall_within_the_connection_radius_is_kept(gap):
    (wall, parked), left, owner = Drive().see(WALL, car(4.0, 8.0 - gap - 0.9), scans=10)
    assert wall <= 0.02
    assert parked >= 0.8
    assert len(np.unique(left.label[(owner == 1) & (left.label != NOT_USED)])) == 1


def test_a_car_that_touches_a_wall_with_its_front_is_kept():
    across = car(0.0, 0.0)[:, ::-1] + np.array([3.0, 8.0 - 2.3 - 0.1])
    (wall, parked), _, _ = Drive().see(WALL, across, scans=10)
    assert wall <= 0.02
    assert parked >= 0.8


def queue(y=4.0, gap=0.6):
    """Five cars, 25.4 m in all by default."""
    return [car((4.6 + gap) * (number - 2), y) for number in range(5)]


def test_a_queue_of_cars_is_no_wall():
    left, segments, owner = Drive().see(*queue(), scans=20)
    assert min(left) >= 0.9
    used = segments.label != NOT_USED
    assert len({(a, b) for a, b in zip(owner[used], segments.label[used], strict=True)}) == 5


def test_a_car_is_seen_where_a_queue_stood():
    drive = Drive()
    drive.see(*queue(), scans=20)
    drive.see(WALL, scans=10)
    (wall, parked), _, _ = drive.see(WALL, car(2.0, 4.0))
    assert wall <= 0.02
    assert parked >= 0.9


def test_a_car_is_seen_in_few_frames_where_a_tram_longer_than_any_vehicle_stood():
    drive = Drive()
    tram = car(0.0, 6.0, 32.0, 2.5)
    (left,), _, _ = drive.see(tram, scans=20)
    assert left == 0.0
    far = house((-30.0, 14.0), (30.0, 15.0))
    assert drive.see(far, car(2.0, 5.65))[0][1] == 0.0  # in its cells, which are still remembered
    drive.see(far, scans=30)
    assert drive.see(far, car(2.0, 5.65))[0][1] >= 0.9


def test_a_queue_is_seen_where_a_tram_stood_although_no_beam_passes_its_cells():
    drive = Drive()
    drive.see(car(0.0, 6.0, 32.0, 2.5), scans=20)
    assert max(drive.see(*queue(5.65, 0.45))[0]) == 0.0
    assert min(drive.see(*queue(5.65, 0.45), scans=40)[0]) >= 0.9


def test_a_wall_that_traffic_hides_for_a_while_stays_known():
    drive = Drive()
    drive.see(WALL, scans=10)
    lorries = [car(x, 4.0, 12.0, 2.5) for x in (-13.0, 13.0)]
    (wall, *vehicles), _, owner = drive.see(WALL, car(0.0, 4.0), *lorries, scans=100)
    assert np.mean(owner == 0) < 0.25
    assert wall <= 0.02
    assert min(vehicles) >= 0.9


def test_a_wall_between_parked_cars_stays_known():
    drive = Drive()
    drive.see(WALL, scans=10)
    (wall, *vehicles), _, _ = drive.see(WALL, *[car(8.6 * (n - 2), 5.5) for n in range(5)], scans=60)
    assert wall <= 0.05
    assert min(vehicles) >= 0.9


def test_a_guard_rail_beside_the_lane_is_removed_and_the_car_beside_it_kept():
    rail = house((-40.0, 3.4), (45.0, 3.6))
    (wall, passing), _, _ = Drive().see(rail, car(14.0, 3.4 - 0.5 - 0.9), scans=10)
    assert wall <= 0.03
    assert passing >= 0.8


def test_a_bent_wall_of_facets_is_removed():
    bent = np.array([[-20.0, 6.0], [-10.0, 9.0], [0.0, 10.0], [10.0, 9.0], [20.0, 6.0], [20.0, 12.0], [-20.0, 12.0]])
    (wall,), _, _ = Drive().see(bent, scans=5)
    assert wall <= 0.02


def test_a_wall_is_forgotten_in_time():
    """Evidence of one scan, 0.85, falls below 0.4 after 60 ln(0.85 / 0.4) = 45.2 s."""
    points = np.stack([np.linspace(-15.0, 15.0, 301), np.full(301, 8.1)], axis=1)
    segments = segment(points, np.ones(301, np.bool_), SegmentationConfig())
    piece = segment(points, np.abs(points[:, 0]) < 3.0, SegmentationConfig())
    for wait, remembered in ((45.0, True), (45.5, False)):
        background = Background(BackgroundConfig())
        background.forget(0.0, points)
        background.remove(points, segments)
        background.forget(wait, np.zeros((0, 2)))
        assert (background.remove(points, piece).count == 0) == remembered


def test_a_wall_is_forgotten_when_beams_of_an_ego_far_from_the_start_pass_it():
    ego, angle = np.array([200.0, -100.0]), np.radians(np.arange(0.0, 360.0, 0.25))
    wall = ego + np.stack([np.linspace(-15.0, 15.0, 301), np.full(301, 8.1)], axis=1)
    beyond = ego + 30.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    segments = segment(wall, np.ones(301, np.bool_), SegmentationConfig())
    piece = segment(wall, np.abs(wall[:, 0] - ego[0]) < 3.0, SegmentationConfig())
    for scans, remembered in ((1, True), (2, False)):  # 0.85 - 0.4 is above the limit of 0.4, 0.85 - 0.8 is below
        background = Background(BackgroundConfig())
        background.forget(0.0, wall, ego)
        background.remove(wall, segments, ego)
        for scan in range(1, scans + 1):
            background.forget(0.3 * scan, beyond, ego)
        assert (background.remove(wall, piece, ego).count == 0) == remembered


def test_straight_runs_have_no_gaps_and_are_longer_than_a_van():
    x = np.arange(0.0, 30.0, 0.1)
    x = x[(x < 8.0) | ((x > 9.5) & (x < 15.0)) | (x > 16.5)]  # 8.0, 5.5 and 13.4 m
    run, line = straight_runs(
        np.stack([x - 15.0, np.full(len(x), 5.0)], axis=1), math.radians(0.5), SegmentationConfig()
    )
    assert ((run != NOT_USED) == ((x < 8.0) | (x > 16.0))).all()
    assert len(set(run[x < 8.0])) == len(set(run[x > 16.0])) == 1
    assert run[0] != run[-1]
    assert line[0] == line[-1]


def test_nearness_equals_all_distances():
    rng = np.random.default_rng(4)
    points, others, radius = rng.uniform(0, 9, (60, 2)), rng.uniform(0, 9, (200, 2)), rng.uniform(0, 0.5, 60)
    distance = np.linalg.norm(points[:, None] - others[None], axis=2)
    expected = (distance <= radius[:, None]).any(axis=1)
    assert 5 < expected.sum() < 55
    assert (any_within(points, others, radius) == expected).all()
    assert not any_within(points, others[:0], radius).any()


@pytest.mark.parametrize(
    ("make", "key", "value"),
    [
        (BackgroundConfig, "memory_s", 0.0),
        (BackgroundConfig, "length_min_m", -1.0),
        (LidarConfig, "range_std_m", 0.0),
        (LidarConfig, "beam_deg", -1.0),
        (LidarConfig, "pitch_deg", 90.0),
    ],
)
def test_bad_settings_name_key_value_and_remedy(make, key, value):
    with pytest.raises(ValueError, match=rf"{key} is {value}; give "):
        make(**{key: value})
