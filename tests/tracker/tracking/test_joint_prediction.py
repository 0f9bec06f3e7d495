"""Prediction of all tracks in one batch, against the prediction of each track."""

import copy

import numpy as np
import pytest

from tests.support.one_track import DT, follow, start, straight
from tracker.records import MODELS
from tracker.tracking.filter_bank import SelectedBank
from tracker.tracking.filters import FilterConfig, initial_filters, motion
from tracker.tracking.joint_prediction import predict, predict_banks
from tracker.tracking.mma import MmaConfig
from tracker.tracking.output import report


def arc(speed, yaw_rate, frames):
    """Return (K, 3) poses of a vehicle that turns."""
    yaw = yaw_rate * DT * np.arange(1, frames + 1)
    radius = speed / yaw_rate
    return np.stack([20.0 + radius * np.sin(yaw), 3.5 + radius * (1.0 - np.cos(yaw)), yaw], axis=1)


def mixed_traffic():
    """Return tracks that stand, drive straight on, turn, and use other filter banks."""
    banks = ("mma", "mma", "mma", "imm", "paper", "average")
    tracks = [start((20.0, 3.5, 0.0), mma=MmaConfig(method=method)) for method in banks]
    tracks.append(start((20.0, 3.5, 0.0), mma=MmaConfig(mode_time_s=1.0)))
    follow(tracks[0], straight((20.0, 3.5, 0.0), 0.0, 12))
    for track in tracks[1:]:
        follow(track, arc(9.0, 0.01, 12))
    follow(tracks[2], arc(9.0, 0.6, 12))
    return tracks


def test_a_batch_predicts_as_each_track_alone():
    """The batch contains the same operations on the same numbers, so that all bits agree."""
    together, alone = mixed_traffic(), mixed_traffic()
    for dt in (DT, 0.5):
        step = motion(dt, FilterConfig())
        predict(together, step)
        for track in alone:
            track.predict(step)
    for one, other in zip(together, alone, strict=True):
        found, expected = report([one]), report([other])
        for name in ("mean", "covariance", "model_probability", "model_position_odom", "model_covariance_odom"):
            np.testing.assert_array_equal(getattr(found, name), getattr(expected, name), name)
        np.testing.assert_array_equal(one.corner.bank.filters.covariance, other.corner.bank.filters.covariance)
        assert np.isnan(found.model_nis).all()
        assert one.unseen_s == other.unseen_s == pytest.approx(DT + 0.5)


def test_each_bank_has_its_own_states():
    """States of a batch share no memory: a shift of one bank leaves the others unchanged."""
    config = FilterConfig()
    banks = [SelectedBank(initial_filters(np.full(2, float(k)), np.eye(2), config), MmaConfig()) for k in range(3)]
    predict_banks(banks, [motion(DT, config)] * 3)
    before = copy.deepcopy([bank.filters for bank in banks])
    banks[1].shift(np.ones(6))
    banks[1].inflate(np.eye(2))
    for k in (0, 2):
        np.testing.assert_array_equal(banks[k].filters.mean, before[k].mean)
        np.testing.assert_array_equal(banks[k].filters.covariance, before[k].covariance)
    np.testing.assert_array_equal(banks[1].filters.mean, before[1].mean + 1.0)


def test_a_bank_with_its_own_prediction_is_not_in_the_batch():
    class Counting(SelectedBank):
        calls = 0

        def predict(self, motion):
            super().predict(motion)
            self.calls += 1

    config = FilterConfig()
    kinds = (Counting, SelectedBank)
    own, other = (kind(initial_filters(np.zeros(2), np.eye(2), config), MmaConfig()) for kind in kinds)
    predict_banks([own, other], [motion(DT, config)] * 2)
    assert own.calls == 1
    np.testing.assert_array_equal(own.filters.covariance, other.filters.covariance)
    assert len(other.probability) == len(MODELS)


def test_no_tracks_need_no_prediction():
    predict([], motion(DT, FilterConfig()))
