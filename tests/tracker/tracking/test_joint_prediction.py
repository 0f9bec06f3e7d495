"""Prediction of all tracks in one batch, against the prediction of each track."""

import copy

import numpy as np
import pytest

from luxloop.tracker.records import MODELS
from luxloop.tracker.tracking.filter_bank import SelectedBank
from luxloop.tracker.tracking.filters import FilterConfig, initial_filters, motion
from luxloop.tracker.tracking.joint_prediction import predict, predict_banks
from luxloop.tracker.tracking.mma import MmaConfig
from tests.support.mixed_traffic import assert_equal, mixed_traffic
from tests.support.one_track import DT


def test_a_batch_predicts_as_each_track_alone():
    """The batch contains the same operations on the same numbers, so that all bits agree."""
    together, alone = mixed_traffic(), mixed_traffic()
    for dt in (DT, 0.5):
        step = motion(dt, FilterConfig())
        predict(together, step)
        for track in alone:
            track.predict(step)
    for one, other in zip(together, alone, strict=True):
        assert_equal(one, other)
        assert np.isnan(one.corner.independent.nis).all()
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
