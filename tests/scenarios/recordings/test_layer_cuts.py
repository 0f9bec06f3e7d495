"""Layer cuts and ring numbers on a spinning sensor of eight rings over flat ground."""

import numpy as np
import pytest

from luxloop.scenarios.recordings.layer_cut import ElevationCut, HeightCut, Rings
from luxloop.scenarios.recordings.sweep import Sweep

ELEVATIONS = np.array([3.0, 1.0, -1.0, -2.0, -3.0, -4.0, -6.0, -9.0])
"""By ring: the device numbers them from above."""


def sweep(distance=10.0, azimuths=36):
    """Points on a cylinder around the sensor."""
    ring, azimuth = np.meshgrid(np.arange(8), (np.arange(azimuths) + 0.5) * 2 * np.pi / azimuths)
    ring, azimuth = ring.ravel(), azimuth.ravel()
    level = np.full(len(ring), distance)
    points = np.column_stack(
        [level * np.cos(azimuth), level * np.sin(azimuth), level * np.tan(np.deg2rad(ELEVATIONS[ring]))]
    )
    return Sweep(0.0, 0, points, np.zeros(len(ring)), ring)


def test_the_nearest_rings_become_layers_from_below():
    whole = sweep()
    layer = ElevationCut((-1.2, -2.0, -2.8, -3.6)).layers(whole, Rings.of(whole))
    kept = {int(ring): int(layer[whole.ring == ring][0]) for ring in np.unique(whole.ring[layer >= 0])}
    assert kept == {5: 0, 4: 1, 3: 2, 2: 3}
    assert (layer >= 0).sum() == 4 * 36


def test_rings_without_a_cut_are_numbered_from_below():
    whole = sweep()
    layer = Rings.of(whole).layers(whole)
    assert (layer == 7 - whole.ring).all()


def test_rings_in_any_order_of_the_device_are_numbered_from_below():
    """Three rings in a cycle: the order of the elevations is not its own inverse."""
    elevation = np.deg2rad([1.0, 3.0, -1.0])
    points = np.column_stack([np.full(3, 10.0), np.zeros(3), 10.0 * np.tan(elevation)])
    cycle = Sweep(0.0, 0, points, np.zeros(3), np.arange(3))
    assert Rings.of(cycle).layers(cycle).tolist() == [1, 2, 0]


def test_a_ring_keeps_its_layer_in_a_sweep_that_lacks_others():
    whole = sweep()
    part = whole.subset(whole.ring >= 3)
    assert (Rings.of(whole).layers(part) == 7 - part.ring).all()


def test_points_without_rings_are_cut_by_their_own_elevation():
    whole = sweep()
    bare = Sweep(0.0, 0, whole.points, whole.time_offset)
    layer = ElevationCut((-2.1, -5.0)).layers(bare, Rings.of(bare))
    assert (layer[whole.ring == 3] == 1).all()
    assert (layer[whole.ring != 3] == -1).all()  # -5 has no point within a quarter of a degree


def test_heights_keep_the_nearest_point_of_each_azimuth_step():
    near, far = sweep(10.0), sweep(20.0)
    both = Sweep(0.0, 0, np.vstack([far.points, near.points]), np.zeros(2 * len(near)))
    height = both.points[:, 2] + 2.0
    # On the near cylinder ring 4 is 1.476 m high, on the far one ring 3 is 1.302 m and ring 2 is 1.651 m high.
    layer = HeightCut((1.4,), 0.15, 10.0).layers(both, height)
    kept = np.flatnonzero(layer == 0)
    assert len(kept) == 36
    assert np.hypot(*both.points[kept, :2].T) == pytest.approx(10.0)
    assert height[kept] == pytest.approx(2.0 - 10.0 * np.tan(np.deg2rad(3.0)))


def test_a_point_near_two_heights_has_the_lower_layer():
    whole = sweep(10.0)
    layer = HeightCut((1.4, 1.5), 0.1, 10.0).layers(whole, whole.points[:, 2] + 2.0)
    assert (layer[whole.ring == 4] == 0).all()  # 1.476 m high
    assert (layer[whole.ring != 4] == -1).all()
