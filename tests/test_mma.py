import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracker import mma
from tracker.mma import MmaConfig

CONFIG = MmaConfig()


def test_update_is_bayes_rule():
    # (12) by hand: priors 1/3 each, likelihoods 1, 2, 1 -> 1/4, 1/2, 1/4.
    posterior = mma.update(mma.initial_probability(), np.log([1.0, 2.0, 1.0]), CONFIG)
    assert posterior == pytest.approx([0.25, 0.5, 0.25])


def test_a_common_outlier_changes_nothing():
    prior = np.array([0.2, 0.5, 0.3])
    assert mma.update(prior, np.full(3, -1e6), CONFIG) == pytest.approx(prior)


@settings(deadline=None)
@given(st.lists(st.tuples(*[st.floats(-1e4, 50)] * 3), min_size=1, max_size=20))
def test_probabilities_sum_to_one_and_never_reach_zero(evidence):
    probability = mma.initial_probability()
    for log_likelihood in evidence:
        probability = mma.update(probability, np.array(log_likelihood), CONFIG)
        assert probability.sum() == pytest.approx(1.0)
        assert probability.min() >= CONFIG.probability_floor / (1 + 3 * CONFIG.probability_floor)


def test_a_model_comes_back_after_a_long_time_out_of_favour():
    probability = mma.initial_probability()
    for _ in range(1000):
        probability = mma.update(probability, np.array([0.0, -5.0, -5.0]), CONFIG)
    for _ in range(6):
        probability = mma.update(probability, np.array([-2.0, 0.0, -2.0]), CONFIG)
    assert probability.argmax() == 1


def test_floor_must_leave_room_for_a_choice():
    with pytest.raises(ValueError, match="probability_floor"):
        MmaConfig(probability_floor=0.4)
