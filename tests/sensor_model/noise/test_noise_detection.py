"""Detection thresholds by power and geometry, and causes of lost beams."""

from pathlib import Path

import numpy as np
import pytest
import scipy
from support.naive_noise import soft_threshold
from support.noise_scenes import ALL, BEAMS, HARD, NAMES, thresholds, within

from luxloop.sensor_model.noise.detection import DetectionThresholds, loss_causes
from luxloop.sensor_model.noise.noise_config import Dirt, DirtSector, Dropout, FixedOutage, NoiseConfig, Outage, Sun
from luxloop.sensor_model.noise.random_draws import Draws, Purpose
from luxloop.sensor_model.noise.thresholds import Thresholds
from luxloop.sensor_model.rig.beams import beam_table
from luxloop.sensor_model.rig.rig import load_rig
from luxloop.sensor_model.truth import Loss

K = BEAMS.units.threshold[0]
HALF = Dirt(True, (DirtSector("front left", -5.0, 10.0, transmission=0.7),))


def of_frames(dropout, frames, first=0):
    detection = DetectionThresholds(NoiseConfig(dropout=dropout), BEAMS, Draws(1, BEAMS), NAMES)
    return [detection.thresholds(frame, 0.08 * frame, 0.0) for frame in range(first, first + frames)]


def causes(limits):
    """Return the (B,) causes of loss of echoes at the nominal threshold of each beam."""
    return loss_causes(limits, ALL, limits.nominal, limits.nominal)


def test_soft_thresholds_equal_reference_implementation():
    result = thresholds(NoiseConfig(dropout=Dropout(softness_db=2.0, random_rate=0.1)), frame=9, seed=4)
    for beam in [*range(0, 4692, 37), 4691]:
        own, lost = soft_threshold(
            [4, 0], 9, Purpose.DROPOUT, BEAMS.unit[beam], BEAMS.index[beam], K, softness_db=2.0, random_rate=0.1
        )
        assert result.nominal[beam] == pytest.approx(own, rel=1e-12)
        assert result.threshold[beam] == (np.inf if lost else result.nominal[beam])
        assert result.blind[beam] == (Loss.RANDOM if lost else Loss.THRESHOLD)


@pytest.mark.parametrize("first", [0, 100_000])
def test_detection_probability_rises_with_power_along_a_logistic(first):
    """10, 50 and 90 % at -0.5, 0 and +0.5 dB; in between a Kolmogorov-Smirnov test. After 1e5 frames too."""
    own = np.concatenate([each.nominal for each in of_frames(Dropout(random_rate=0.0), 10, first)])
    margin_db = 10 * np.log10(own / K)
    for power_db, share in [(-0.5, 0.1), (0.0, 0.5), (0.5, 0.9)]:
        assert within(np.sum(margin_db <= power_db), len(own), share)
    assert scipy.stats.kstest(margin_db, scipy.stats.logistic(scale=1 / (2 * np.log(9))).cdf).pvalue > 1e-3


def test_random_losses_have_their_rate():
    lost = np.concatenate([np.isinf(each.threshold) for each in of_frames(Dropout(random_rate=0.05), 10)])
    assert within(lost.sum(), len(lost), 0.05)


def test_threshold_is_that_of_the_unit_without_noise():
    """The LUX detects 10 % at 50 m: 0.1 / 50^2 = 4e-5. Fails if losses of a frame carry over to the next."""
    detection = DetectionThresholds(NoiseConfig(dropout=HARD), BEAMS, Draws(1, BEAMS), NAMES)
    for frame in range(2):
        result = detection.thresholds(frame, 0.08 * frame, 0.0)
        assert np.all(result.threshold == pytest.approx(4e-5))
        assert np.all(result.blind == Loss.THRESHOLD)
        assert np.all(result.firing)


def test_dirt_attenuates_twice_and_only_in_its_sector():
    result = thresholds(NoiseConfig(dropout=HARD, dirt=HALF))
    azimuth = np.rad2deg(BEAMS.azimuth)
    dirty = (BEAMS.unit == 0) & (azimuth > -5.01) & (azimuth < 10.01)
    assert 100 < dirty.sum() < 200
    assert result.threshold[dirty] == pytest.approx(4e-5 / 0.49)
    assert result.threshold[~dirty] == pytest.approx(4e-5)
    assert np.array_equal(causes(result) == Loss.DIRT, dirty)
    assert result.nominal == pytest.approx(4e-5)


def test_blocked_sector_has_infinite_thresholds():
    result = thresholds(NoiseConfig(dropout=HARD, dirt=Dirt(True, (DirtSector("*", -5.0, 5.0, 0.0),))))
    assert np.array_equal(np.isinf(result.threshold), np.abs(np.rad2deg(BEAMS.azimuth)) < 5.01)


@pytest.mark.parametrize(("sun_deg", "ego_deg"), [(0.0, 0.0), (90.0, 60.0), (-170.0, 170.0), (350.0, 0.0)])
def test_sun_reduces_the_gain_of_beams_towards_it(sun_deg, ego_deg):
    sun = Sun(True, azimuth_deg=sun_deg, half_width_deg=15.0, gain=0.6)
    result = thresholds(NoiseConfig(dropout=HARD, sun=sun), ego_yaw=np.deg2rad(ego_deg))
    heading_deg = np.rad2deg(np.arctan2(*BEAMS.direction_ego[:, 1::-1].T)) + ego_deg
    off_deg = np.abs((heading_deg - sun_deg + 180) % 360 - 180)
    sunlit = off_deg < 15 - 1e-6
    assert 100 < sunlit.sum() < 1500
    assert result.threshold[sunlit] == pytest.approx(4e-5 / 0.6)
    assert result.threshold[off_deg > 15 + 1e-6] == pytest.approx(4e-5)
    assert np.all(causes(result)[sunlit] == Loss.SUN)


def test_cause_of_loss_follows_the_order_of_priority():
    """Outage before random loss before dirt before sun; the factors of dirt and sun multiply."""
    out = Outage(True, mean_uptime_s=1e9, fixed=(FixedOutage("rear left", 0.0, 1.0),))
    config = NoiseConfig(
        dropout=Dropout(softness_db=0.0, random_rate=0.2),
        outage=out,
        dirt=Dirt(True, (DirtSector("*", -60.0, 0.0, 0.5),)),
        sun=Sun(True, half_width_deg=180.0),
    )
    result = thresholds(config)
    chance = Draws(1, BEAMS).uniform(0, ALL, Purpose.DROPOUT)[1] < 0.2
    expected = np.select(
        [BEAMS.unit == NAMES.index("rear left"), chance, BEAMS.azimuth < 1e-9],
        [Loss.OUTAGE, Loss.RANDOM, Loss.DIRT],
        Loss.SUN,
    )
    assert np.array_equal(causes(result), expected)
    assert set(expected) == {Loss.OUTAGE, Loss.RANDOM, Loss.DIRT, Loss.SUN}
    limits = {Loss.OUTAGE: np.inf, Loss.RANDOM: np.inf, Loss.DIRT: K / 0.25 / 0.6, Loss.SUN: K / 0.6}
    for loss, threshold in limits.items():
        assert result.threshold[expected == loss] == pytest.approx(threshold)
    assert np.array_equal(result.firing, expected != Loss.OUTAGE)


@pytest.mark.parametrize(
    ("blind", "transmission", "gain", "peak", "dry", "loss"),
    [
        (Loss.THRESHOLD, 1.0, 1.0, 3.0, 3.0, Loss.THRESHOLD),
        (Loss.OUTAGE, 1.0, 1.0, 3.0, 3.0, Loss.THRESHOLD),  # too weak for a working unit
        (Loss.OUTAGE, 1.0, 1.0, 5.0, 5.0, Loss.OUTAGE),
        (Loss.RANDOM, 1.0, 1.0, 5.0, 5.0, Loss.RANDOM),
        (Loss.RANDOM, 0.5, 0.5, 5.0, 5.0, Loss.RANDOM),
        (Loss.THRESHOLD, 0.5, 1.0, 5.0, 5.0, Loss.DIRT),
        (Loss.THRESHOLD, 0.0, 1.0, 1e9, 1e9, Loss.DIRT),
        (Loss.THRESHOLD, 1.0, 0.5, 5.0, 5.0, Loss.SUN),
        (Loss.THRESHOLD, 1.0, 1.0, 3.0, 5.0, Loss.AIR),
        (Loss.THRESHOLD, 0.5, 1.0, 5.0, 9.0, Loss.AIR),  # detected with dirt alone
        (Loss.THRESHOLD, 0.5, 1.0, 3.0, 5.0, Loss.DIRT),  # also lost with rain alone, but dirt has priority
        (Loss.OUTAGE, 1.0, 1.0, 3.0, 5.0, Loss.OUTAGE),
        # Dirt and sun: clean 4 / gain, shaded 4 / transmission are the thresholds; both together need more.
        (Loss.THRESHOLD, 0.998, 0.3, 5.0, 5.0, Loss.SUN),
        (Loss.THRESHOLD, 0.3, 0.998, 5.0, 5.0, Loss.DIRT),
        (Loss.THRESHOLD, 0.998, 0.3, 13.35, 13.35, Loss.DIRT),  # detected with sun alone, and with slight dirt alone
        (Loss.THRESHOLD, 0.5, 0.4, 6.0, 6.0, Loss.SUN),  # lost with either alone: the stronger
        (Loss.THRESHOLD, 0.4, 0.5, 6.0, 6.0, Loss.DIRT),
    ],
)
def test_cause_of_a_lost_beam(blind, transmission, gain, peak, dry, loss):
    """The threshold of a clean, shaded unit is 4 here."""
    with np.errstate(divide="ignore"):
        raised = np.array([4.0]) / (gain * np.array([transmission]))
    one = Thresholds(
        threshold=raised if blind == Loss.THRESHOLD else np.array([np.inf]),
        nominal=np.array([4.0]),
        gain=np.array([gain]),
        transmission=np.array([transmission]),
        blind=np.array([blind], np.uint8),
        firing=np.array([True]),
    )
    assert loss_causes(one, np.array([0]), np.array([peak]), np.array([dry])).tolist() == [loss]


def test_slight_dirt_is_not_the_cause_of_a_loss_by_the_sun():
    """Power 1.5 K: the sun of gain 0.3 alone suppresses it, dirt of transmission 0.999 alone does not."""
    dirt = Dirt(True, (DirtSector("*", -60.0, 60.0, transmission=0.999),))
    limits = thresholds(NoiseConfig(dropout=HARD, dirt=dirt, sun=Sun(True, half_width_deg=180.0, gain=0.3)))
    power = np.full(len(ALL), 1.5 * K)
    assert np.all(power < limits.threshold)
    assert np.all(loss_causes(limits, ALL, power, power) == Loss.SUN)


def test_only_the_mirror_face_of_the_frame_fires():
    rig = load_rig("srx_six_lux_8l", Path())
    beams = beam_table(rig)
    even, odd = (thresholds(frame=frame, beams=beams, names=[m.name for m in rig.mounts]).firing for frame in (6, 7))
    assert np.array_equal(even, ~odd)
    assert even.sum() == len(BEAMS)
    assert len(np.unique(beams.layer[even])) == 4


def test_unknown_unit_is_refused():
    for config in (
        NoiseConfig(dirt=Dirt(True, (DirtSector("roof", -5.0, 5.0),))),
        NoiseConfig(outage=Outage(True, fixed=(FixedOutage("roof", 0.0, 1.0),))),
    ):
        with pytest.raises(ValueError, match="unit = 'roof': not a unit of the rig; name one of: front left, "):
            thresholds(config)


def test_switches_do_not_change_the_other_draws():
    """Fails if kinds of noise share a sequence of random numbers."""
    plain, all_on = (
        thresholds(NoiseConfig()),
        thresholds(
            NoiseConfig(dirt=HALF, sun=Sun(True), outage=Outage(True, fixed=(FixedOutage("side left", 0.0, 9.0),)))
        ),
    )
    assert np.array_equal(plain.nominal, all_on.nominal)
    lost = plain.blind == Loss.RANDOM
    assert lost.sum() > 20
    assert np.all(np.isin(all_on.blind[lost], [Loss.RANDOM, Loss.OUTAGE]))
