"""Terrain of roads and the contact of bodies with it, against hand calculations."""

import math

import numpy as np
import pytest

from luxloop.sim.road_terrain import CELL_M, TRACK_SHARE, WHEELBASE_SHARE, LaneSections, ground_contact, road_terrain
from luxloop.sim.world import Terrain

CAR = np.array([[4.7, 1.8, 1.5]])


def lanes(*ends, half_width=1.6):
    return LaneSections(np.array(ends, dtype=np.float64), np.full(len(ends), half_width))


RAMP = lanes(((0, 0, 0), (100, 0, 0)), ((100, 0, 0), (200, 0, 6)), ((200, 0, 6), (300, 0, 6)))
"""Flat, 6 % from x = 100 m to x = 200 m, flat."""


def test_interpolation_is_linear_in_each_triangle():
    """The diagonal from (0, 0) to (1, 1) divides the cell: below it (u > v) lies node (1, 0), above it node (0, 1)."""
    terrain = Terrain(np.array([10.0, 20.0]), 2.0, np.array([[0.0, 1.0], [2.0, 7.0]]))
    places = np.array([[10, 20], [12, 20], [10, 22], [12, 22], [11.5, 20.5], [10.5, 21.5], [11, 21]])
    # 0.75 x 2 + 0.25 x (7 - 2) = 2.75 and 0.75 x 1 + 0.25 x (7 - 1) = 2.25
    assert terrain.height_at(places) == pytest.approx([0, 2, 1, 7, 2.75, 2.25, 3.5])
    beyond = np.array([[0.0, 21.0], [30.0, 40.0]])
    assert terrain.height_at(beyond) == pytest.approx([0.5, 7.0]), "the border continues outwards"


def test_terrain_has_the_height_of_the_lane_across_its_width():
    terrain, above = road_terrain(RAMP)
    x = np.arange(0.0, 300.0, 7.3)
    x = x[(np.abs(x - 100) > CELL_M + 2) & (np.abs(x - 200) > CELL_M + 2)]  # off the kinks
    wanted = 0.06 * np.clip(x - 100.0, 0.0, 100.0)
    for y in (-1.0, 0.0, 1.0):
        assert terrain.height_at(np.column_stack([x, np.full(len(x), y)])) == pytest.approx(wanted, abs=2e-3)
    assert above == 0


def test_surroundings_continue_the_nearest_lane_smoothly():
    """On the ramp's middle the rise along the road is the lane's at every distance, and flat across, by symmetry."""
    terrain, _ = road_terrain(RAMP)
    for y in (10.0, 25.0, 39.0, 60.0):
        before, middle, after = terrain.height_at(np.array([[140.0, y], [150.0, y], [160.0, y]]))
        assert middle == pytest.approx(3.0, abs=0.05)
        assert after - before == pytest.approx(1.2, abs=0.15)
    steps = np.abs(np.diff(terrain.height, axis=1)).max(), np.abs(np.diff(terrain.height, axis=0)).max()
    assert max(steps) < 1.5 * 0.06 * CELL_M, "no cliffs"


def test_ground_is_the_lower_of_two_roads_and_a_bridge_takes_the_simulator_s_height():
    over = ((50, -60, 6), (50, 60, 6))
    terrain, above = road_terrain(lanes(((0, 0, 0), (100, 0, 0)), over))
    crossing, on_bank = terrain.height_at(np.array([[50.0, 0.0], [50.0, 40.0]]))
    assert crossing == pytest.approx(0.0, abs=0.01)
    assert on_bank == pytest.approx(6.0, abs=0.1), "off the lower road, the ground carries the upper one"
    assert above > 0
    pose = np.array([[50.0, 0.0, 0.5 * math.pi]] * 3)
    road = np.array([[6.0, 0.02], [0.1, 0.02], [math.nan, math.nan]])
    height, slope = ground_contact(terrain, pose, np.repeat(CAR, 3, axis=0), road)
    assert height == pytest.approx([6.0, 0.0, 0.0], abs=0.05)
    assert slope[0] == pytest.approx([-0.02, 0.0])
    assert slope[1:] == pytest.approx(np.zeros((2, 2)), abs=0.02)


@pytest.mark.parametrize(("yaw_deg", "pitch", "roll"), [(0, -0.06, 0), (180, 0.06, 0), (90, 0, -0.06), (-90, 0, 0.06)])
def test_pitch_and_roll_on_a_plane(yaw_deg, pitch, roll):
    """Uphill the front is up: a negative pitch. Facing left of uphill, the right side is up: a negative roll."""
    x = 2.0 * np.arange(20)
    terrain = Terrain(np.zeros(2), 2.0, np.repeat(0.06 * x[:, None], 20, axis=1))
    pose = np.array([[19.0, 20.0, math.radians(yaw_deg)]])
    height, slope = ground_contact(terrain, pose, CAR, None)
    assert height == pytest.approx([0.06 * 19.0])
    assert slope[0] == pytest.approx([math.atan(pitch), math.atan(roll)], abs=1e-12)


def test_a_body_tilts_gradually_over_a_kink():
    """With its centre on the foot, the front axle is half a wheelbase up the ramp: half its slope."""
    rise = 0.06 * np.maximum(2.0 * np.arange(-20, 21), 0)
    terrain = Terrain(np.array([-40.0, -10.0]), 2.0, np.repeat(rise[:, None], 11, axis=1))
    wheelbase, track = WHEELBASE_SHARE * CAR[0, 0], TRACK_SHARE * CAR[0, 1]
    assert (wheelbase, track) == pytest.approx((2.82, 1.53))
    height, slope = ground_contact(terrain, np.zeros((1, 3)), CAR, None)
    assert height == pytest.approx([0.06 * wheelbase / 4])
    assert slope[0] == pytest.approx([-math.atan(0.03), 0.0])


def test_a_body_beside_a_kink_along_the_road_has_the_height_of_its_wheels():
    """On the crown of a road that falls by 4 % to both sides, all wheels are half a track away from it."""
    fall = -0.04 * np.abs(2.0 * np.arange(-5, 6))
    terrain = Terrain(np.array([-10.0, -10.0]), 2.0, np.repeat(fall[None], 11, axis=0))
    height, slope = ground_contact(terrain, np.zeros((1, 3)), CAR, None)
    assert height == pytest.approx([-0.04 * 1.53 / 2])
    assert slope[0] == pytest.approx([0.0, 0.0])
