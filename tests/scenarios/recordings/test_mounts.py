"""Mounts: rotation order of rig files, and height, pitch and roll from the ground."""

import numpy as np
import pytest

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.recordings.ego_mount import EgoMount, levelled, of_rig
from luxloop.sensor_model.rig.beams import unit_table


def test_a_mount_places_points_by_hand():
    left = EgoMount.parse("1,2,0.5,90")
    assert left.to_ego(np.array([[3.0, 0.0, 0.0]])) == pytest.approx(np.array([[1.0, 5.0, 0.5]]))
    down = EgoMount.parse("0,0,2,0,30,0")
    assert down.to_ego(np.array([[2.0, 0.0, 0.0]]))[0] == pytest.approx([np.sqrt(3.0), 0.0, 1.0])


def test_mounts_of_a_rig_are_those_of_its_beams():
    rig, mounts = of_rig("srx_six_lux")
    table = unit_table(rig)
    assert np.array([mount.origin_ego for mount in mounts]) == pytest.approx(table.origin_ego)
    assert np.array([mount.R_ego_unit for mount in mounts]) == pytest.approx(table.R_ego_unit)


def street(mount, noise_m=0.02):
    """Points on flat ground, on walls and on cars around a sensor, in its frame."""
    rng = np.random.default_rng(1)
    ground = np.column_stack([rng.uniform(-25, 25, (6000, 2)), np.zeros(6000)])
    cars = np.vstack([centre + rng.uniform(0, 1, (800, 3)) * (4.5, 1.8, 1.4)
                      for centre in ([4, 3, 0.2], [-9, 3, 0.2], [6, -6, 0.2], [-6, -6, 0.2])])  # fmt: skip
    wall = np.column_stack([rng.uniform(-25, 25, 2000), np.full(2000, 9.0), rng.uniform(0, 6, 2000)])
    points = np.vstack([ground, cars, wall]) + noise_m * rng.standard_normal((11200, 3))
    return (points - mount.origin_ego) @ mount.R_ego_unit


@pytest.mark.parametrize(("pitch", "roll"), [(0.0, 0.0), (2.0, -1.5), (-3.0, 2.5)])
def test_levelling_finds_height_pitch_and_roll(pitch, roll):
    true = EgoMount.of(np.array([0.3, 0.1, 1.85]), 20.0, pitch, roll)
    start = EgoMount.of(np.array([0.3, 0.1, 1.0]), 20.0, 0.0, 0.0)
    found = levelled(street(true), start)
    assert found.origin_ego == pytest.approx(true.origin_ego, abs=0.02)
    tilt = np.degrees(np.arccos(np.clip(found.R_ego_unit[2] @ true.R_ego_unit[2], -1.0, 1.0)))
    assert tilt < 0.15


def test_levelling_needs_ground():
    with pytest.raises(InputError, match="--level"):
        levelled(np.array([[5.0, 0.0, 1.0]] * 20), EgoMount.parse("0,0,1"))
