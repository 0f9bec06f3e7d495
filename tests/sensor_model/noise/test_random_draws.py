"""Random draws: published test vectors, and independence."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.naive_caster import philox4x32
from support.naive_noise import uniforms
from support.noise_scenes import ALL, BEAMS, RIG

from luxloop.sensor_model.kernels.noise import beam_pairs, counter_pairs
from luxloop.sensor_model.kernels.philox import philox
from luxloop.sensor_model.noise.random_draws import Draws, Purpose
from luxloop.sensor_model.rig.beams import beam_table

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
def test_philox_reproduces_published_words(counter, key, words):
    assert list(philox(*counter, *key)) == words
    assert philox4x32(counter, key) == words


@given(counter=st.tuples(word, st.integers(0, 255), st.integers(0, 2**31 - 1), word), seed=st.integers(0, 2**64 - 1))
def test_draws_equal_reference_implementation(counter, seed):
    """The draws depend on counter and seed only: no time, no state, no entropy of the machine."""
    frame, unit, index, purpose = counter
    key = np.array([seed % 2**32, seed // 2**32], dtype=np.uint32)
    expected = uniforms(key, *counter)
    assert counter_pairs(key, *(np.array([name]) for name in counter))[:, 0].tolist() == expected
    table = np.array([9, unit], np.uint8), np.array([9, index], np.int32)
    of_beam = beam_pairs(key, frame, *table, np.array([1]), np.array([purpose]))
    assert of_beam[:, 0].tolist() == expected


@pytest.mark.parametrize("first", [0, 100_000])
def test_normal_draws_are_standard_normal_early_and_late(first):
    """Moments of 94800 draws; the bounds are four standard errors. Fails if noise becomes a pattern in long runs."""
    draws = Draws(5, BEAMS)
    z = np.concatenate([draws.normal(frame, ALL, Purpose.RANGE) for frame in range(first, first + 20)])
    n = len(z)
    assert abs(z.mean()) < 4 / np.sqrt(n)
    assert abs(z.std() - 1) < 4 / np.sqrt(2 * n)
    assert abs((z**3).mean()) < 4 * np.sqrt(15 / n)
    assert abs((z**4).mean() - 3) < 4 * np.sqrt(96 / n)


def test_draws_of_frames_beams_numbers_seeds_and_purposes_are_independent():
    """Fails if a field of the counter is ignored, because two of the series would be equal."""
    draws = Draws(5, BEAMS)
    series = [draws.normal(0, ALL, Purpose.RANGE)]
    series.append(draws.normal(1, ALL, Purpose.RANGE))
    series.append(draws.normal(0, ALL, Purpose.DROPOUT))
    series.append(draws.normal(0, ALL, Purpose.RANGE, number=1))
    series.append(draws.normal(0, ALL, Purpose.RANGE, number=2))
    series.append(Draws(6, BEAMS).normal(0, ALL, Purpose.RANGE))
    series.append(Draws(5 + 2**32, BEAMS).normal(0, ALL, Purpose.RANGE))
    series.append(draws.normal_of(0, ALL, 0, Purpose.MOUNT))
    series.append(draws.normal_of(0, 0, ALL, Purpose.MOUNT))
    series.append(draws.normal_of(ALL, 0, 0, Purpose.MOUNT))
    series.append(np.roll(series[0], 1))
    series.append(np.roll(series[0], 782))
    correlation = np.corrcoef(series)[np.triu_indices(len(series), 1)]
    assert np.abs(correlation).max() < 4.5 / np.sqrt(len(ALL))


def test_draw_depends_only_on_its_beam():
    draws = Draws(5, BEAMS)
    some = np.array([4691, 3, 782])
    assert np.array_equal(draws.normal(7, some, Purpose.RANGE), draws.normal(7, ALL, Purpose.RANGE)[some])


def test_draws_of_a_beam_differ_by_their_number():
    draws = Draws(5, BEAMS)
    number = ALL % 3
    one_by_one = np.choose(number, [draws.normal(7, ALL, Purpose.RANGE, each) for each in range(3)])
    assert np.array_equal(draws.normal(7, ALL, Purpose.RANGE, number), one_by_one)


def test_added_unit_changes_no_draw_of_the_others():
    """Fails if draws come from a sequence whose length or order depends on all beams."""
    more = beam_table(replace(RIG, mounts=(*RIG.mounts, replace(RIG.mounts[0], name="another", yaw_deg=0.0))))
    assert np.array_equal(Draws(5, BEAMS).normal(3, ALL, Purpose.RANGE), Draws(5, more).normal(3, ALL, Purpose.RANGE))


def test_counters_are_taken_modulo_a_word():
    """Births before the start of the run have negative counters."""
    draws = Draws(5, BEAMS)
    assert np.array_equal(
        draws.uniform_of(-1, 0, 7, Purpose.SPRAY_BIRTH), draws.uniform_of(2**32 - 1, 0, 7, Purpose.SPRAY_BIRTH)
    )


def test_purposes_do_not_collide_with_numbers_or_each_other():
    assert max(Purpose) < 256
    assert len(set(Purpose)) == len(Purpose.__members__)
