"""Calibration errors of the units, and doubled points."""

from dataclasses import replace

import numpy as np
import pytest
from support.noise_scenes import BEAMS, RIG

from luxloop.sensor_model.noise.calibration import doubled_points, sync_jitter, true_mounts
from luxloop.sensor_model.noise.noise_config import CalibrationError
from luxloop.sensor_model.noise.random_draws import Draws
from luxloop.sensor_model.rig.beams import beam_table, unit_table

ON = CalibrationError(True)
UNITS = BEAMS.units


def errors(config, seeds=1500):
    """Return translations [m] and rotation vectors [deg] in the unit's frame, of all units over many runs."""
    shift, turn = [], []
    for seed in range(seeds):
        origin, R_ego_unit = true_mounts(config, UNITS, Draws(seed, BEAMS))
        error = np.swapaxes(UNITS.R_ego_unit, 1, 2) @ R_ego_unit
        shift.append(origin - UNITS.origin_ego)
        turn.append(np.rad2deg([error[:, 2, 1], error[:, 0, 2], error[:, 1, 0]]).T)
    return np.concatenate(shift), np.concatenate(turn)


def test_mount_errors_have_their_sigmas_in_the_unit_frame():
    """Separate roll, pitch and yaw; 9000 draws, four standard errors."""
    config = replace(ON, yaw_sigma_deg=0.1, pitch_sigma_deg=0.2, roll_sigma_deg=0.3)
    shift, turn = errors(config)
    tolerance = 4 / np.sqrt(2 * len(shift))
    np.testing.assert_allclose(shift.std(axis=0), [0.02, 0.02, 0.01], rtol=tolerance)
    np.testing.assert_allclose(turn.std(axis=0), [0.3, 0.2, 0.1], rtol=tolerance)
    assert np.all(np.abs(shift.mean(axis=0)) < 4 * np.array([0.02, 0.02, 0.01]) / np.sqrt(len(shift)))
    correlation = np.corrcoef(np.hstack([shift, turn]).T)[np.triu_indices(6, 1)]
    assert np.abs(correlation).max() < 4.5 / np.sqrt(len(shift))


def test_mounts_are_rotations_and_constant_over_a_run():
    origin, R_ego_unit = true_mounts(ON, UNITS, Draws(3, BEAMS))
    np.testing.assert_allclose(R_ego_unit @ np.swapaxes(R_ego_unit, 1, 2), np.tile(np.eye(3), (6, 1, 1)), atol=1e-12)
    again = true_mounts(ON, UNITS, Draws(3, BEAMS))
    assert np.array_equal(origin, again[0])
    assert np.array_equal(R_ego_unit, again[1])


@pytest.mark.parametrize(("without", "axis", "normal"), [("roll", 1, 2), ("yaw", 0, 1)])
def test_mounts_turn_by_yaw_then_pitch_then_roll(without, axis, normal):
    """Large errors show the order: y stays level until the roll, and x in its plane without a yaw."""
    large = {f"{turn}_sigma_deg": 0.0 if turn == without else 10.0 for turn in ("yaw", "pitch", "roll")}
    for seed in range(5):
        _, R_ego_unit = true_mounts(replace(ON, **large), UNITS, Draws(seed, BEAMS))
        error = np.swapaxes(UNITS.R_ego_unit, 1, 2) @ R_ego_unit
        np.testing.assert_allclose(error[:, normal, axis], 0.0, atol=1e-12)
        assert np.abs(error[:, axis, normal]).max() > 0.01


def test_mounts_and_times_are_exact_if_disabled():
    origin, R_ego_unit = true_mounts(CalibrationError(False), UNITS, Draws(3, BEAMS))
    assert np.array_equal(origin, UNITS.origin_ego)
    assert np.array_equal(R_ego_unit, UNITS.R_ego_unit)
    assert np.all(sync_jitter(CalibrationError(False), 6, 4, Draws(3, BEAMS)) == 0.0)


def test_sync_jitter_is_drawn_for_each_frame_and_unit():
    draws = Draws(3, BEAMS)
    jitter = np.array([sync_jitter(ON, 6, frame, draws) for frame in range(2000)])
    np.testing.assert_allclose(jitter.std(axis=0), 1e-3, rtol=4.5 / np.sqrt(4000))
    between = np.corrcoef(jitter.T)[np.triu_indices(6, 1)]
    assert np.abs(between).max() < 4.5 / np.sqrt(2000)
    assert abs(np.corrcoef(jitter[1:, 0], jitter[:-1, 0])[0, 1]) < 4.5 / np.sqrt(2000)


def test_added_unit_does_not_change_the_others():
    more = replace(RIG, mounts=(*RIG.mounts, replace(RIG.mounts[0], name="another")))
    draws, draws_more = Draws(3, BEAMS), Draws(3, beam_table(more))
    for before, after in zip(true_mounts(ON, UNITS, draws), true_mounts(ON, unit_table(more), draws_more), strict=True):
        assert np.array_equal(before, after[:6])
    assert np.array_equal(sync_jitter(ON, 6, 4, draws), sync_jitter(ON, 7, 4, draws_more)[:6])


def test_displaced_points_on_actors_seen_by_two_units_are_doubled():
    """Actor 0 is seen by units 0 and 1, actor 1 by unit 0 only; -1 means no actor."""
    actor = np.array([0, 0, 0, 1, 1, -1])
    unit = np.array([0, 0, 1, 0, 0, 1], np.uint8)
    displacement = np.array([0.11, 0.09, 0.0, 0.11, 0.12, 0.5])
    result = doubled_points(ON, displacement, unit, actor, 2)
    assert result.tolist() == [True, False, False, False, False, False]
    assert doubled_points(ON, np.empty(0), np.empty(0, np.uint8), np.empty(0, np.int64), 0).tolist() == []


def test_yaw_error_displaces_far_points_more():
    """0.1 deg at 57 m is 10 cm, the default limit: nearer points are doubled by several errors, or large ones."""
    assert pytest.approx(np.deg2rad(ON.yaw_sigma_deg) * 57.3, rel=0.01) == ON.doubled_beyond_m
