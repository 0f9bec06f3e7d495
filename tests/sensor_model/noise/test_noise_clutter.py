"""False alarms and rain: statistics, and merging of echoes in a beam."""

from dataclasses import replace

import numpy as np
import pytest
import scipy
from hypothesis import given
from hypothesis import strategies as st
from support import naive_noise
from support.noise_scenes import ALL, BEAMS, HARD, RIG, healthy, returns, thresholds, within

from luxloop.sensor_model.kernels.noise import rare_beams, separate_echoes
from luxloop.sensor_model.noise.clutter_mixing import merge, unit_beams, weak_clutter
from luxloop.sensor_model.noise.false_alarms import false_alarms, wrong_flags
from luxloop.sensor_model.noise.noise_config import (
    Dirt,
    DirtSector,
    Dropout,
    FalseAlarms,
    FixedOutage,
    NoiseConfig,
    Outage,
    Rain,
    Sun,
)
from luxloop.sensor_model.noise.rain import drops, extinction
from luxloop.sensor_model.noise.random_draws import Draws
from luxloop.sensor_model.returns import NOTHING
from luxloop.sensor_model.rig.beams import beam_table
from luxloop.sensor_model.truth import Cause, Part
from luxloop.tracker.scan import PointFlag

OPEN = np.full(len(BEAMS), np.inf)
SIDE_LEFT_OUT = NoiseConfig(dropout=HARD, outage=Outage(True, fixed=(FixedOutage("side left", 0.0, 9.0),)))
KEY = np.array([5, 0], np.uint32)


def of(beam, range_, part=Part.NONE, cause=Cause.FALSE_ALARM, beams=BEAMS):
    beam = np.asarray(beam, np.int64)
    labelled, weakest = np.zeros(len(beam), np.bool_), np.ones(len(beam))
    return weak_clutter(beam, np.asarray(range_, np.float64), weakest, part, cause, labelled, beams, healthy())


@given(rate=st.sampled_from([1.0, 0.3, 0.01, 1e-6, 1e-300]), frame=st.integers(0, 2**32 - 1))
def test_rare_beams_equal_reference_implementation(rate, frame):
    unit_beam = np.array([0, 7, 7, 30])
    expected = naive_noise.rare_beams(KEY, frame, 6, unit_beam, rate)
    assert rare_beams(KEY, frame, 6, unit_beam, rate).tolist() == expected


@pytest.mark.parametrize(("rate", "frames"), [(0.02, 400), (1e-4, 20_000)])
@pytest.mark.parametrize("first", [0, 100_000])
def test_geometric_gaps_give_independent_beams_of_equal_probability(rate, frames, first):
    """Counts are binomial, over frames and over beams. Fails if the first beams are preferred."""
    unit_beam = unit_beams(BEAMS)
    found = [rare_beams(KEY, frame, 6, unit_beam, rate) for frame in range(first, first + frames)]
    total = sum(map(len, found))
    assert within(total, frames * len(BEAMS), rate)
    counts = np.bincount(np.concatenate(found) // 92, minlength=51)  # 51 groups of 92 beams
    assert scipy.stats.chisquare(counts).pvalue > 1e-3
    per_frame = np.array([len(each) for each in found])
    assert per_frame.var() == pytest.approx(len(BEAMS) * rate * (1 - rate), rel=5 * np.sqrt(2 / frames + 1 / total))


def test_added_unit_changes_no_rare_beam_of_the_others():
    more = beam_table(replace(RIG, mounts=(*RIG.mounts, replace(RIG.mounts[0], name="another"))))
    for frame in range(20):
        found = rare_beams(KEY, frame, 6, unit_beams(more), 0.01)
        assert np.array_equal(rare_beams(KEY, frame, 6, unit_beams(BEAMS), 0.01), found[found < len(BEAMS)])


def test_false_alarms_are_uniform_over_range_and_on_no_actor():
    some = [false_alarms(FalseAlarms(rate=0.05), BEAMS, healthy(), Draws(2, BEAMS), frame) for frame in range(20)]
    assert within(sum(map(len, some)), 20 * len(BEAMS), 0.05)
    ranges = np.concatenate([each.range for each in some])
    assert scipy.stats.kstest(ranges, scipy.stats.uniform(0.3, 199.7).cdf).pvalue > 1e-3
    assert all(np.all(each.cause == Cause.FALSE_ALARM) and not each.flags.any() for each in some)


@pytest.mark.parametrize("make", [
    lambda thresholds: false_alarms(FalseAlarms(rate=0.2), BEAMS, thresholds, Draws(2, BEAMS), 0),
    lambda thresholds: drops(Rain(True, rate_mm_per_h=100.0), BEAMS, thresholds, Draws(2, BEAMS), 0),
])  # fmt: skip
def test_silent_unit_has_no_clutter(make):
    """Fails if a silent unit has clutter, or if its outage changes the clutter of other units."""
    all_units, without = make(healthy()), make(thresholds(SIDE_LEFT_OUT))
    of_others = BEAMS.unit[all_units.beam] != 2
    assert 0 < of_others.sum() < len(all_units)
    assert np.array_equal(all_units.beam[of_others], without.beam)
    assert np.array_equal(all_units.range[of_others], without.range)


@pytest.mark.parametrize("first", [0, 100_000])
def test_drops_have_their_rate_and_lognormal_ranges(first):
    """1.69e-4 per mm/h, log range 1.362 +- 0.784 (TU Darmstadt's fit to a VLP-32); half of them labelled."""
    rain = Rain(True, rate_mm_per_h=20.0)
    some = [drops(rain, BEAMS, healthy(), Draws(2, BEAMS), frame) for frame in range(first, first + 200)]
    ranges = np.concatenate([each.range for each in some])
    assert within(len(ranges), 200 * len(BEAMS), 1.69e-4 * 20)
    assert scipy.stats.kstest(ranges, scipy.stats.lognorm(s=0.784, scale=np.exp(1.362)).cdf).pvalue > 1e-3
    flags = np.concatenate([each.flags for each in some])
    assert within(np.sum(flags == PointFlag.CLUTTER), len(flags), 0.5)
    assert np.all(np.isin(flags, [0, PointFlag.CLUTTER]))


def rained(config):
    """Return the drops of 200 frames of heavy rain, each (frame, beam) as one number."""
    rain, need = Rain(True, rate_mm_per_h=100.0), thresholds(config)
    some = [drops(rain, BEAMS, need, Draws(2, BEAMS), frame) for frame in range(200)]
    return np.concatenate([frame * len(BEAMS) + each.beam for frame, each in enumerate(some)])


def test_blocked_window_sees_no_rain():
    """Nor does a blind beam. Fails if drops are detected through opaque dirt."""
    blocked = Dirt(True, (DirtSector("*", -180.0, 180.0, transmission=0.0),))
    assert len(rained(NoiseConfig(dropout=HARD, dirt=blocked))) == 0
    assert len(rained(NoiseConfig(dropout=Dropout(random_rate=1.0)))) == 0


def test_raised_threshold_keeps_its_share_of_the_drops():
    """Dirt of transmission 0.8 and a sun of gain 0.5 leave 0.8^2 0.5 of them, and add none."""
    dirt = Dirt(True, (DirtSector("*", -180.0, 180.0, transmission=0.8),))
    clean = rained(NoiseConfig(dropout=HARD))
    dull = rained(NoiseConfig(dropout=HARD, dirt=dirt, sun=Sun(True, half_width_deg=180.0, gain=0.5)))
    assert len(clean) > 10_000
    assert within(len(dull), len(clean), 0.32)
    assert np.all(np.isin(dull, clean))


def test_extinction_of_rain_is_that_of_carbonneau_and_wisely():
    """1.076 R^0.67 dB/km: 1.076 dB per kilometre at 1 mm/h, 9.30 dB at 25 mm/h."""
    assert np.exp(-1000 * extinction(Rain(True, rate_mm_per_h=1.0))) == pytest.approx(10**-0.1076, rel=1e-12)
    assert np.exp(-1000 * extinction(Rain(True, rate_mm_per_h=25.0))) == pytest.approx(10**-0.930, rel=1e-3)
    assert extinction(Rain()) == 0.0


@pytest.mark.parametrize("make", [
    lambda need, frame: false_alarms(FalseAlarms(rate=0.05), BEAMS, need, Draws(2, BEAMS), frame),
    lambda need, frame: drops(Rain(True, rate_mm_per_h=100.0), BEAMS, need, Draws(2, BEAMS), frame),
])  # fmt: skip
def test_powers_of_clutter_fall_as_their_inverse_and_widths_follow_as_for_surfaces(make):
    """The share of echoes above x times the threshold is 1 / x; each decibel widens the pulse by the unit's growth."""
    need = healthy()
    some = [make(need, frame) for frame in range(60)]
    ratio = np.concatenate([each.power / need.nominal[each.beam] for each in some])
    assert scipy.stats.kstest(1.0 / ratio, scipy.stats.uniform().cdf).pvalue > 1e-3
    over_db = np.concatenate([10 * np.log10(each.power / need.threshold[each.beam]) for each in some])
    width = np.concatenate([each.width for each in some])
    np.testing.assert_allclose(width, 0.675 + 0.032 * np.maximum(over_db, 0.0), atol=1e-12)
    assert len(np.unique(width)) > 0.9 * len(width)


def test_wrong_flags_have_their_rate_and_differ_from_frame_to_frame():
    config, place = FalseAlarms(flagged=0.02), np.zeros(len(ALL), np.int64)
    some = [wrong_flags(config, ALL, place, Draws(2, BEAMS), frame) for frame in range(20)]
    assert within(np.sum(some), 20 * len(ALL), 0.02)
    assert not np.array_equal(some[0], some[1])
    assert not wrong_flags(replace(config, enabled=False), ALL, place, Draws(2, BEAMS), 0).any()


def test_rain_does_not_change_the_false_alarms():
    before = false_alarms(FalseAlarms(rate=0.1), BEAMS, healthy(), Draws(2, BEAMS), 4)
    draws = Draws(2, BEAMS)
    drops(Rain(True), BEAMS, healthy(), draws, 4)
    after = false_alarms(FalseAlarms(rate=0.1), BEAMS, healthy(), draws, 4)
    assert np.array_equal(before.beam, after.beam)
    assert np.array_equal(before.range, after.range)


ranges = st.lists(st.floats(0.3, 30.0), max_size=8).map(sorted)


@given(beams=st.lists(ranges, max_size=5), separation=st.floats(0.0, 6.0), echoes_max=st.integers(1, 3))
def test_separate_echoes_equal_reference_implementation(beams, separation, echoes_max):
    beam = np.repeat(np.arange(len(beams)), [len(each) for each in beams]).astype(np.int64)
    range_ = np.array([r for each in beams for r in each], dtype=np.float64)
    width = 0.3 + range_ % 1.0
    kept, merged = separate_echoes(
        beam, range_, width, np.full(len(beam), separation), np.full(len(beam), echoes_max, np.int64)
    )
    for number, each in enumerate(beams):
        echoes = [(r, 0.3 + r % 1.0) for r in each]
        mine = kept & (beam == number)
        expected = naive_noise.separate_echoes(echoes, separation, echoes_max)
        np.testing.assert_allclose(np.column_stack([range_[mine], merged[mine]]), np.reshape(expected, (-1, 2)))


def test_merged_clutter_is_ordered_by_beam_and_range():
    merged = merge(returns([3, 8, 8], [20.0, 10.0, 30.0]), [of([8, 2], [20.0, 50.0])], OPEN, BEAMS)
    assert merged.beam.tolist() == [2, 3, 8, 8, 8]
    assert merged.range.tolist() == [50.0, 20.0, 10.0, 20.0, 30.0]
    assert merged.target.tolist() == [NOTHING, 0, 1, NOTHING, 2]
    assert merged.cause.tolist() == [Cause.FALSE_ALARM, 0, 0, Cause.FALSE_ALARM, 0]
    assert merged.echo.tolist() == [0, 0, 0, 1, 2]
    assert merged.width[1] == 0.5
    assert merged.width[0] == BEAMS.units.pulse_length[0]


def test_only_the_nearest_echoes_are_kept():
    """Three per beam: clutter in front displaces a far surface."""
    merged = merge(returns([8], [40.0]), [of([8, 8, 8], [10.0, 20.0, 30.0])], OPEN, BEAMS)
    assert merged.range.tolist() == [10.0, 20.0, 30.0]


def test_echo_too_close_to_the_previous_one_merges_with_it():
    separation = BEAMS.units.echo_separation[0]
    near, far = 20.0 - 0.9 * separation, 20.0 - 1.1 * separation
    assert merge(returns([8], [20.0]), [of([8], [far])], OPEN, BEAMS).range.tolist() == [far, 20.0]
    merged = merge(returns([8], [20.0]), [of([8], [near])], OPEN, BEAMS)
    assert merged.range.tolist() == [near]
    assert merged.target.tolist() == [NOTHING]
    assert merged.width.tolist() == pytest.approx([20.0 + 0.5 - near])


def test_surface_hides_drops_but_not_false_alarms():
    """This includes surfaces without an echo."""
    free = OPEN.copy()
    free[[5, 6]] = 15.0
    some = [of([5, 5, 6], [14.0, 16.0, 14.5], Part.DROPLET, Cause.RAIN), of([6], [22.0])]
    merged = merge(returns([], []), some, free, BEAMS)
    assert merged.beam.tolist() == [5, 6, 6]
    assert merged.range.tolist() == [14.0, 14.5, 22.0]


def test_clutter_beyond_the_limits_of_a_unit_is_dropped():
    merged = merge(returns([], []), [of([1, 2, 3], [0.1, 5.0, 250.0], Part.DROPLET, Cause.RAIN)], OPEN, BEAMS)
    assert merged.range.tolist() == [5.0]


def test_returns_are_unchanged_without_clutter():
    """Misses stay misses."""
    some = returns([3, 8, 8], [20.0, 10.0, 10.1])
    assert merge(some, [], OPEN, BEAMS) is some
    assert merge(some, [of([], [])], OPEN, BEAMS) is some


def test_beams_without_clutter_keep_their_echoes():
    """Fails if columns are reordered differently."""
    rng = np.random.default_rng(4)
    beam = np.sort(rng.choice(ALL, 2000, replace=False))
    before = returns(beam, rng.uniform(1, 100, 2000))
    clutter = false_alarms(FalseAlarms(rate=0.01), BEAMS, healthy(), Draws(2, BEAMS), 0)
    after = merge(before, [clutter], OPEN, BEAMS)
    others = ~np.isin(before.beam, clutter.beam)
    kept = ~np.isin(after.beam, clutter.beam)
    assert np.array_equal(before.target[others], after.target[kept])
    assert np.array_equal(before.range[others], after.range[kept])
    assert np.array_equal(before.width[others], after.width[kept])


def test_clutter_beyond_all_returns_stays_in_its_beam():
    merged = merge(returns([3, 4], [20.0, 10.0]), [of([3], [90.0])], OPEN, BEAMS)
    assert merged.beam.tolist() == [3, 3, 4]
    assert merged.range.tolist() == [20.0, 90.0, 10.0]
