"""Outages: statistics of the Markov chain."""

import math

import numpy as np
import pytest
from support.naive_noise import silent_unit
from support.noise_scenes import BEAMS, NAMES, within

from luxloop.sensor_model.kernels.noise import silent_units
from luxloop.sensor_model.noise.noise_config import FixedOutage, Outage
from luxloop.sensor_model.noise.outage import TICK_S, Outages, transitions
from luxloop.sensor_model.noise.random_draws import Draws, Purpose

FRAME_S = 0.08
OFTEN = Outage(True, mean_uptime_s=20.0, mean_outage_s=2.0)


def outages(config=OFTEN, names=NAMES, seed=3):
    return Outages(config, Draws(seed, BEAMS), names)


def test_states_equal_reference_implementation():
    """The kernel searches backwards for the last decisive draw; the reference steps forward through all draws."""
    config = Outage(True, mean_uptime_s=0.5, mean_outage_s=0.2)
    failing, recovering = transitions(config)
    for tick in [0, 1, 2, 30, 31, 200]:
        expected = [silent_unit([3, 0], tick, Purpose.OUTAGE, unit, failing, recovering) for unit in range(6)]
        assert outages(config).silent(tick * TICK_S).tolist() == expected


@pytest.mark.parametrize("ticks", [1, 2, 4, 5])
def test_times_of_frames_are_whole_ticks(ticks):
    """Fails if rounding of a time puts a frame into the tick before."""
    config = Outage(True, mean_uptime_s=0.05, mean_outage_s=0.05)
    of_run, rates, key = outages(config), transitions(config), np.array([3, 0], np.uint32)
    for frame in range(1000):
        expected = silent_units(key, ticks * frame, int(Purpose.OUTAGE), len(NAMES), *rates)
        assert np.array_equal(of_run.silent(frame * (ticks * TICK_S)), expected)


def test_transitions_are_those_of_a_process_in_continuous_time():
    """Twice the probability 0.02 / 20 at first order, and never above 1."""
    failing, recovering = transitions(OFTEN)
    assert failing == pytest.approx(TICK_S / 20.0, rel=0.01)
    assert recovering == pytest.approx(TICK_S / 2.0, rel=0.01)
    failing, recovering = transitions(Outage(True, mean_uptime_s=1e-9, mean_outage_s=1e-9))
    assert failing + recovering <= 1.0
    assert transitions(Outage(True, mean_uptime_s=1e9))[0] < 1e-10


def test_uptimes_outages_and_share_hold_over_1e5_frames_and_after_a_new_start():
    """Mean durations in frames: 1 / P(transition within a frame). Fails if long runs change the noise."""
    of_run = outages()
    silent = np.array([of_run.silent(FRAME_S * frame) for frame in range(100_000)])
    for part in (silent[:50_000], silent[50_000:]):
        down, stays = part.mean(), np.sum(part[1:] & ~part[:-1])
        share = 2.0 / 22.0
        # States of mean duration d give a mean over time T with the variance 2 share^2 (1 - share) d / T per unit.
        error = math.sqrt(2 * share * (1 - share) ** 2 * 2.0 / (len(part) * FRAME_S * 6))
        assert down == pytest.approx(share, abs=4.5 * error)
        leave = -math.expm1(-(1 / 20 + 1 / 2) * FRAME_S) * 20 / 22
        assert part.sum() / stays == pytest.approx(1 / leave, rel=4.5 / math.sqrt(stays))
        assert (~part).sum() / stays == pytest.approx(10 / leave, rel=4.5 / math.sqrt(stays))
    again = outages()
    for frame in [99_999, 3, 50_000, 17]:
        assert np.array_equal(again.silent(FRAME_S * frame), silent[frame])


def test_initial_state_is_stationary():
    """Fails if every run starts with all units working."""
    starts = np.array([outages(seed=seed).silent(0.0) for seed in range(2000)])
    assert within(starts.sum(), starts.size, 2 / 22)


def test_outages_do_not_depend_on_the_scan_rate():
    slow, fast = outages(), outages()
    for frame in range(0, 400, 7):
        assert np.array_equal(slow.silent(0.08 * frame), fast.silent(0.04 * (2 * frame)))


def test_added_unit_does_not_change_the_others():
    for frame in range(0, 3000, 10):
        assert np.array_equal(outages().silent(0.08 * frame), outages(names=[*NAMES, "roof"]).silent(0.08 * frame)[:6])


def test_fixed_outages_begin_and_end_on_time():
    fixed = (FixedOutage("side left", 1.0, 2.0), FixedOutage("*", 5.0, 6.0))
    config = Outage(True, mean_uptime_s=1e9, fixed=fixed)
    silent = {time: outages(config).silent(time).tolist() for time in (0.99, 1.0, 1.99, 2.0, 5.5)}
    side_left = [name == "side left" for name in NAMES]
    assert silent == {0.99: [False] * 6, 1.0: side_left, 1.99: side_left, 2.0: [False] * 6, 5.5: [True] * 6}
