"""Draws against published vectors, losses and range errors against their statistics, switches against each other."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.naive_caster import philox4x32
from support.sensor_scenes import (
    EXACT,
    LUX_RIG,
    Thing,
    ahead,
    beam_origins,
    beams_of,
    one_unit_rig,
    scan,
    small_unit,
    wall,
    world,
)

from sensor_model.beams import beam_table
from sensor_model.draws import Draws, Purpose
from sensor_model.kernels import philox, uniform_pairs
from sensor_model.lidar import Lidar
from sensor_model.noise import Dropout, LayerOverlap, MirrorNoise, NoiseConfig, RangeNoise
from sensor_model.truth import Loss, Part
from sensor_model.unit import Fan
from sim.world import Obstacles

BEAMS = beam_table(LUX_RIG)
ALL = np.arange(len(BEAMS))
ROOM = Obstacles.from_polygons([20.0 * np.array([[1.0, 1], [-1, 1], [-1, -1], [1, -1]])], [5.0], reflectivity=0.8)
word = st.integers(0, 2**32 - 1)


@pytest.mark.parametrize(
    ("counter", "key", "words"),
    [
        # kat_vectors of Random123 (Salmon et al.), philox4x32-10.
        ([0] * 4, [0] * 2, [0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8]),
        ([0xFFFFFFFF] * 4, [0xFFFFFFFF] * 2, [0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD]),
        (
            [0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344],
            [0xA4093822, 0x299F31D0],
            [0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1],
        ),
    ],
)
def test_philox_gives_the_published_words(counter, key, words):
    assert list(philox(*counter, *key)) == words
    assert philox4x32(counter, key) == words


@given(
    frame=word,
    unit=st.integers(0, 255),
    index=st.integers(0, 2**31 - 1),
    purpose=st.integers(0, 9),
    seed=st.integers(0, 2**64 - 1),
)
@settings(deadline=None, max_examples=200)
def test_uniform_pairs_equal_their_naive_twin(frame, unit, index, purpose, seed):
    key = np.array([seed % 2**32, seed // 2**32], dtype=np.uint32)
    pair = uniform_pairs(key, frame, np.array([unit], np.uint8), np.array([index], np.int32), purpose)
    words = philox4x32([frame, unit, index, purpose], key.tolist())
    assert pair[:, 0].tolist() == [(words[0] + 0.5) / 2**32, (words[1] + 0.5) / 2**32]


def test_normal_draws_are_standard_normal():
    """Moments of 94800 draws; the bounds are four standard errors."""
    draws = Draws(5, BEAMS)
    z = np.concatenate([draws.normal(frame, ALL, Purpose.RANGE) for frame in range(20)])
    n = len(z)
    assert abs(z.mean()) < 4 / np.sqrt(n)
    assert abs(z.std() - 1) < 4 / np.sqrt(2 * n)
    assert abs((z**3).mean()) < 4 * np.sqrt(15 / n)
    assert abs((z**4).mean() - 3) < 4 * np.sqrt(96 / n)


def test_draws_of_frames_beams_seeds_and_purposes_are_unrelated():
    """Fails when a counter's field is dropped: two of the series would then be the same."""
    draws = Draws(5, BEAMS)
    series = [draws.normal(0, ALL, Purpose.RANGE)]
    series.append(draws.normal(1, ALL, Purpose.RANGE))
    series.append(draws.normal(0, ALL, Purpose.DROPOUT))
    series.append(Draws(6, BEAMS).normal(0, ALL, Purpose.RANGE))
    series.append(Draws(5 + 2**32, BEAMS).normal(0, ALL, Purpose.RANGE))
    series.append(np.roll(series[0], 1))
    series.append(np.roll(series[0], 790))
    correlation = np.corrcoef(series) - np.eye(len(series))
    assert np.abs(correlation).max() < 4.5 / np.sqrt(len(ALL))


def test_a_draw_depends_on_its_own_beam_only():
    draws = Draws(5, BEAMS)
    some = np.array([4739, 3, 790])
    assert np.array_equal(draws.normal(7, some, Purpose.RANGE), draws.normal(7, ALL, Purpose.RANGE)[some])


def range_errors(range_noise, frames=4):
    """Errors of every beam in a closed room, as (frames, beams) [m]."""
    lidar = Lidar(LUX_RIG, replace(EXACT, range=range_noise), seed=3, obstacles=ROOM)
    errors = []
    for frame in range(frames):
        result, truth = lidar.scan(world(index=frame))
        assert len(result) == len(BEAMS)
        ranges = np.linalg.norm(result.points_ego - BEAMS.origin_ego[BEAMS.unit], axis=1)
        errors.append(ranges - truth.true_range)
    return np.array(errors)


def test_range_error_has_the_sigma_and_the_bias_of_each_layer():
    errors = range_errors(RangeNoise())
    for layer, bias in enumerate([-0.0125, 0.0015, 0.0165, -0.0055]):
        of_layer = errors[:, BEAMS.layer == layer]
        assert of_layer.mean() == pytest.approx(bias, abs=4 * 0.025 / np.sqrt(of_layer.size))
        # A quantum of 1 cm adds 1/12 of its square to the variance.
        assert of_layer.std() == pytest.approx(np.sqrt(0.025**2 + 0.01**2 / 12), rel=4 / np.sqrt(2 * of_layer.size))


def test_layer_bias_is_zero_on_average_and_scales():
    assert sum(LUX_RIG.mounts[0].model.layer_bias_m) == pytest.approx(0.0, abs=1e-12)
    errors = range_errors(RangeNoise(sigma_m=0.0, quantum_m=0.0, layer_bias_scale=2.0), frames=1)
    assert errors[0, BEAMS.layer == 2] == pytest.approx(0.033, abs=1e-5)


def test_ranges_are_whole_centimetres_unless_told_otherwise():
    result, _ = scan(noise=replace(EXACT, range=RangeNoise()), obstacles=ROOM)
    ranges_cm = 100.0 * np.linalg.norm(result.points_ego - BEAMS.origin_ego[BEAMS.unit], axis=1)
    assert np.abs(ranges_cm - np.round(ranges_cm)).max() < 1e-3
    errors = range_errors(RangeNoise(sigma_m=0.0, quantum_m=0.0, layer_bias_scale=0.0), frames=1)
    assert np.abs(errors).max() < 1e-5


def test_the_random_floor_takes_its_share():
    noise = replace(EXACT, dropout=Dropout(threshold_per_m2=1e-12, random_rate=0.05))
    lidar = Lidar(LUX_RIG, noise, 3, ROOM)
    truths = [lidar.scan(world(index=frame))[1] for frame in range(5)]
    lost = np.concatenate([truth.lost_cause for truth in truths])
    gain = BEAMS.gain > 0
    assert np.all(lost == Loss.RANDOM)
    assert len(lost) == pytest.approx(0.05 * 5 * gain.sum(), abs=4 * np.sqrt(0.05 * 0.95 * 5 * gain.sum()))


def far_wall(distance, reflectivity):
    return Obstacles.from_polygons([np.array([[distance, -400.0], [distance, 400.0]])], [50.0], reflectivity)


def test_with_a_hard_threshold_exactly_the_weak_beams_are_lost():
    """P = rho cos(incidence) gain / R^2 against 4e-5, worked out here from where each beam meets the wall x = 45."""
    noise = replace(EXACT, dropout=Dropout(softness_db=1e-6, random_rate=0.0))
    result, truth = scan(noise=noise, obstacles=far_wall(45.0, 0.1))
    start, heading = BEAMS.origin_ego[BEAMS.unit], BEAMS.direction_ego
    ranges = (45.0 - start[:, 0]) / np.maximum(heading[:, 0], 1e-9)
    meets = (ranges < 200.0) & (start[:, 2] + ranges * heading[:, 2] > 0.0)
    strong = meets & (0.1 * heading[:, 0] * BEAMS.gain / ranges**2 > 4e-5)
    assert 10 < strong.sum() < 0.5 * meets.sum()

    on_wall = truth.part == Part.OBSTACLE
    assert np.array_equal(beams_of(result, BEAMS)[on_wall], np.flatnonzero(strong))
    np.testing.assert_allclose(truth.true_range[on_wall], ranges[strong], rtol=1e-6)
    lost = 790 * truth.lost_unit.astype(int) + truth.lost_beam
    assert set(np.flatnonzero(meets & ~strong)) <= set(lost)
    assert np.all(truth.lost_cause == Loss.THRESHOLD)


@pytest.mark.parametrize(("margin_db", "share"), [(-0.5, 0.1), (0.0, 0.5), (0.5, 0.9)])
def test_the_threshold_is_soft_by_one_decibel(margin_db, share):
    """A unit looks straight at a wall of 10 % at the range whose power is `margin_db` over that at 50 m."""
    fan = Fan((0,), 0.01, -0.01, 0.0001, (100.0,))
    rig = one_unit_rig(small_unit((fan,), elevation_deg=(0.0,)))
    noise = replace(EXACT, dropout=Dropout(random_rate=0.0))
    result, _ = scan(noise=noise, obstacles=far_wall(50.0 * 10 ** (-margin_db / 20), 0.1), rig=rig)
    assert len(result) / fan.count == pytest.approx(share, abs=4 * np.sqrt(share * (1 - share) / fan.count))


def test_a_black_car_vanishes_beyond_its_range():
    """Paint of 5 % is seen to 50 sqrt(0.05 / 0.1) = 35 m; sensor facts 4.1 give no point at 40 m."""
    near, far = (scan(ahead(gap, paint=0.05), noise=NoiseConfig())[1] for gap in (20.0, 42.0))
    body = [np.sum((truth.actor_id == 0) & (truth.part == Part.BODY)) for truth in (near, far)]
    assert body[0] > 30
    assert body[1] == 0
    assert far.hits[0] > 10


SCENE = (ahead(16.0), Thing(8, 7, 1.0), Thing(-12, 1, 2.0))
HOUSE = wall((5, 20), (40, 15), (40, 30))
"""With room to hide in."""


def by_beam(noise, *more, rig=LUX_RIG, **scene):
    """Reported and true range of every beam of the six units, NaN where nothing returned."""
    result, truth = scan(*SCENE, *more, noise=noise, obstacles=HOUSE, rig=rig, **scene)
    reported, true = np.full((2, len(BEAMS)), np.nan)
    ours = result.unit < 6
    beam = beams_of(result, BEAMS)[ours]
    reported[beam] = np.linalg.norm(result.points_ego - beam_origins(result, BEAMS), axis=1)[ours]
    true[beam] = truth.true_range[ours]
    return reported, true


ALL_ON = NoiseConfig()


@pytest.mark.parametrize(
    "noise",
    [
        replace(ALL_ON, mirror=MirrorNoise(enabled=False)),
        replace(ALL_ON, layer_overlap=LayerOverlap(enabled=False)),
        replace(ALL_ON, dropout=Dropout(enabled=False)),
        replace(ALL_ON, dropout=Dropout(random_rate=0.3)),
    ],
)
def test_a_switch_leaves_the_range_errors_of_unchanged_beams_as_they_were(noise):
    """Fails when a draw depends on how many beams hit, or are lost, before it."""
    before, true_before = by_beam(ALL_ON)
    after, true_after = by_beam(noise)
    same = true_before == true_after
    assert same.sum() > 500
    assert not np.array_equal(before, after, equal_nan=True)
    assert np.array_equal(before[same], after[same])


def test_range_noise_changes_no_loss():
    before, _ = by_beam(ALL_ON)
    after, true = by_beam(replace(ALL_ON, range=RangeNoise(enabled=False)))
    assert np.array_equal(np.isnan(before), np.isnan(after))
    np.testing.assert_allclose(after, true, atol=1e-4)


def test_an_actor_out_of_sight_changes_nothing():
    before, _ = by_beam(ALL_ON)
    after, _ = by_beam(ALL_ON, Thing(25, 21))
    assert np.array_equal(before, after, equal_nan=True)


def test_another_unit_changes_nothing_for_the_others():
    before, _ = by_beam(ALL_ON)
    more = replace(LUX_RIG, mounts=(*LUX_RIG.mounts, replace(LUX_RIG.mounts[0], yaw_deg=0.0)))
    after, _ = by_beam(ALL_ON, rig=more)
    assert np.array_equal(before, after, equal_nan=True)


@pytest.mark.parametrize(
    ("config", "values", "says"),
    [
        (RangeNoise, {"sigma_m": -0.1}, "sigma_m = -0.1: must not be negative"),
        (RangeNoise, {"sigma_m": float("nan")}, "sigma_m = nan: must not be negative"),
        (RangeNoise, {"layer_bias_scale": float("inf")}, "layer_bias_scale = inf: must be finite"),
        (RangeNoise, {"quantum_m": -0.1}, "quantum_m = -0.1: must not be negative"),
        (Dropout, {"threshold_per_m2": 0.0}, "threshold_per_m2 = 0.0: must be positive"),
        (Dropout, {"softness_db": 0.0}, "softness_db = 0.0: must be positive"),
        (Dropout, {"random_rate": 1.5}, "random_rate = 1.5: must be from 0 to 1"),
    ],
)
def test_a_strength_out_of_range_is_refused(config, values, says):
    with pytest.raises(ValueError, match=says):
        config(**values)
