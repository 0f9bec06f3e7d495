"""The whole sensor: the scan's contract, determinism, and counts against published ones."""

import math

import numpy as np
import pytest
from support.sensor_scenes import (
    EXACT,
    LUX_RIG,
    NO_OBSTACLES,
    PLAIN,
    Thing,
    ahead,
    beam_origins,
    beams_of,
    scan,
    wall,
    world,
)

from sensor_model.beams import beam_table
from sensor_model.lidar import Lidar
from sensor_model.noise import NoiseConfig
from sensor_model.truth import NO_ACTOR, Part
from sim.world import Kind

BEAMS = beam_table(LUX_RIG)
STREET = (ahead(8.0), ahead(14.0, y=3.5, kind=Kind.SUV), Thing(-12, -3.5, kind=Kind.VAN), Thing(5, -8, 1.2, Kind.BUS))
FENCE = wall((-40, 9), (40, 9), height=2.0)
DTYPES = {
    "ego_pose_odom": np.float64, "points_ego": np.float32, "time_offset": np.float32, "unit": np.uint8,
    "layer": np.uint8, "echo": np.uint8, "echo_pulse_width": np.float32, "flags": np.uint16,
}  # fmt: skip
TRUTH_DTYPES = {
    "actor_id": np.int64, "part": np.uint8, "cause": np.uint8, "true_range": np.float32, "lost_unit": np.uint8,
    "lost_beam": np.int32, "lost_cause": np.uint8, "hits": np.int32, "hits_alone": np.int32, "faces": np.uint8,
    "view": np.uint8,
}  # fmt: skip


def assert_same(one, other):
    for name in DTYPES:
        assert np.array_equal(getattr(one[0], name), getattr(other[0], name)), name
    for name in TRUTH_DTYPES:
        assert np.array_equal(getattr(one[1], name), getattr(other[1], name)), name


@pytest.mark.parametrize("things", [STREET, ()], ids=["street", "nobody"])
@pytest.mark.parametrize("noise", [NoiseConfig(), PLAIN], ids=["noisy", "plain"])
def test_records_are_as_the_contract_says(things, noise):
    result, truth = scan(*things, noise=noise, obstacles=FENCE)
    for record, dtypes in ((result, DTYPES), (truth, TRUTH_DTYPES)):
        for name, dtype in dtypes.items():
            assert getattr(record, name).dtype == dtype, name
    assert result.points_ego.shape == (len(result), 3)
    assert {len(getattr(truth, name)) for name in ("actor_id", "part", "cause", "true_range")} == {len(result)}
    assert {len(getattr(truth, name)) for name in ("hits", "hits_alone", "faces", "view")} == {len(things)}
    assert {len(truth.lost_unit), len(truth.lost_beam), len(truth.lost_cause)} == {len(truth.lost_unit)}
    assert np.all(np.isfinite(result.points_ego))
    assert not np.any(result.time_offset)
    assert not np.any(result.echo)
    assert not np.any(result.flags)
    assert np.all(result.echo_pulse_width == np.float32(1.35))


def test_points_lie_on_their_beams_in_the_order_of_the_table():
    result, truth = scan(*STREET, obstacles=FENCE)
    beam = beams_of(result, BEAMS)
    assert np.all(np.diff(beam) > 0)
    expected = beam_origins(result, BEAMS) + truth.true_range[:, None] * BEAMS.direction_ego[beam]
    np.testing.assert_allclose(result.points_ego, expected, atol=1e-4)


def test_every_beam_returns_is_lost_or_misses():
    """Fails when a beam is both, or when a miss makes a point."""
    result, truth = scan(*STREET, noise=NoiseConfig(), obstacles=FENCE)
    _, exact = scan(*STREET, noise=EXACT, obstacles=FENCE)
    returned = set(beams_of(result, BEAMS).tolist())
    lost = set((790 * truth.lost_unit.astype(int) + truth.lost_beam).tolist())
    assert not returned & lost
    assert len(returned) + len(lost) == len(exact.part)
    assert len(lost) > 100
    assert np.all(exact.part != Part.NONE)


def test_upper_layers_see_nothing_in_an_empty_world():
    result, truth = scan()
    assert set(result.layer) == {0, 1}
    assert np.all(truth.part == Part.GROUND)
    assert np.abs(result.points_ego[:, 2]).max() < 1e-5
    # The lowest layer of a unit at 0.55 m meets flat ground 26 m away (sensor facts, section 2).
    lowest = truth.true_range[(result.unit == 0) & (result.layer == 0)]
    assert lowest == pytest.approx(0.55 / math.sin(math.radians(1.2)))


def test_same_seed_same_scans():
    frames = [world(*STREET, index=index) for index in range(3)]
    runs = [Lidar(LUX_RIG, NoiseConfig(), seed=9, obstacles=FENCE) for _ in range(2)]
    scans = [[lidar.scan(frame) for frame in frames] for lidar in runs]
    for one, other in zip(*scans, strict=True):
        assert_same(one, other)
    # The noise of a frame depends on its index, not on how many scans came before.
    assert_same(Lidar(LUX_RIG, NoiseConfig(), seed=9, obstacles=FENCE).scan(frames[2]), scans[0][2])


def test_another_seed_or_frame_has_other_noise():
    first, *others = (scan(*STREET, noise=NoiseConfig(), seed=s, index=i)[0] for s, i in ((1, 0), (2, 0), (1, 1)))
    for other in others:
        assert not np.array_equal(first.points_ego, other.points_ego)


def test_actors_may_come_go_and_change():
    """Fails when bodies of the last frame are reused although another actor has taken the place."""
    lidar = Lidar(LUX_RIG, EXACT, 1, NO_OBSTACLES)
    car, truck = ahead(10.0), ahead(10.0, kind=Kind.TRUCK)
    for things in ((car,), (truck,), (car, ahead(10.0, y=4.0)), (), (truck,), (car,)):
        assert_same(lidar.scan(world(*things)), scan(*things))


def test_odometry_is_relative_to_the_first_scan():
    lidar = Lidar(LUX_RIG, EXACT, 1, NO_OBSTACLES)
    start = (1000.0, -500.0, math.radians(170))
    first, _ = lidar.scan(world(ego=start))
    assert first.ego_pose_odom.tolist() == [0, 0, 0]
    # 2 m along and 1 m to the left of a heading of 170 degrees, turned by 30 degrees, over the cut at 180.
    c, s = math.cos(start[2]), math.sin(start[2])
    pose = (1000.0 + 2 * c - s, -500.0 + 2 * s + c, math.radians(-160))
    second, _ = lidar.scan(world(ego=pose, index=1))
    np.testing.assert_allclose(second.ego_pose_odom, [2.0, 1.0, math.radians(30)], atol=1e-9)


@pytest.mark.parametrize(
    ("y", "kind", "gap", "published"),
    [
        # Sensor facts 4.1, points on a lone vehicle ahead, by gap; made with beam footprints, ours with centre rays.
        (0.0, Kind.CAR, 5, 254), (0.0, Kind.CAR, 10, 152), (0.0, Kind.CAR, 20, 68), (0.0, Kind.CAR, 30, 44),
        (3.5, Kind.CAR, 5, 188), (3.5, Kind.CAR, 10, 129), (3.5, Kind.CAR, 20, 64), (3.5, Kind.CAR, 30, 30),
        (0.0, Kind.SUV, 5, 258), (0.0, Kind.SUV, 10, 152), (0.0, Kind.SUV, 20, 70), (0.0, Kind.SUV, 30, 44),
    ],
)  # fmt: skip
def test_as_many_points_on_a_car_as_published(y, kind, gap, published):
    _, truth = scan(ahead(float(gap), y=y, kind=kind), noise=NoiseConfig())
    assert np.sum(truth.actor_id != NO_ACTOR) == pytest.approx(published, rel=0.25)
