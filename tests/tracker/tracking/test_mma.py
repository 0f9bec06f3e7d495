import numpy as np
import pytest
import scipy
from hypothesis import given
from hypothesis import strategies as st
from support.filter_bank import Filters
from support.one_bank import OneBank

from luxloop.tracker.records import MODELS
from luxloop.tracker.tracker import TrackerConfig
from luxloop.tracker.tracking import mma
from luxloop.tracker.tracking.filters import FilterConfig, motion
from luxloop.tracker.tracking.mma import CA, CV, PROBABILITY_FLOOR, STATIONARY, MmaConfig

CONFIG = MmaConfig()
DT = 0.08
R = np.eye(2) * 0.02**2
EQUAL = np.full(3, 1 / 3)


def update(probability, evidence, floor=mma.LEAST_PROBABILITY):
    return mma.update(probability[None], evidence[None], floor)[0]


def score(filters, innovation, noise, dof):
    evidence, scale = mma.score(filters.covariance[None], innovation[None], noise[None], dof)
    return evidence[0], scale[0]


def transitions(filters, dt, config):
    return mma.transitions(filters.mean[None], filters.covariance[None], mma.changes(dt, config, MODELS))[0]


def mix(filters, probability, chain):
    mean, covariance, prior = mma.mix(filters.mean[None], filters.covariance[None], probability[None], chain[None])
    return Filters(mean[0], covariance[0]), prior[0]


def filters(speed=0.0, speed_std=0.1):
    """Three filters at the origin that move along x."""
    mean = np.zeros((3, 6))
    mean[:, 2] = speed
    return Filters(mean, np.tile(np.diag([0.01, 0.01, speed_std**2, speed_std**2, 1.0, 1.0]), (3, 1, 1)))


def test_update_is_bayes_rule():
    # (12) by hand: priors 1/3 each, likelihoods 1, 2, 1 -> 1/4, 1/2, 1/4.
    posterior = update(EQUAL, np.log([1.0, 2.0, 1.0]))
    assert posterior == pytest.approx([0.25, 0.5, 0.25])


def test_a_common_offset_of_the_evidence_has_no_effect():
    prior = np.array([0.2, 0.5, 0.3])
    assert update(prior, np.full(3, -1e6)) == pytest.approx(prior)


@given(st.lists(st.tuples(*[st.floats(-1e4, 50)] * 3), min_size=1, max_size=20))
def test_probabilities_sum_to_one_and_never_fall_below_the_floor(evidence):
    probability, floor = EQUAL, PROBABILITY_FLOOR
    for log_likelihood in evidence:
        probability = update(probability, np.array(log_likelihood), floor)
        assert probability.sum() == pytest.approx(1.0)
        assert probability.min() >= floor / (1 + 3 * floor)


@pytest.mark.parametrize(("dof", "density"), [(4.0, "multivariate_t"), (1e9, "multivariate_normal")])
def test_score_is_the_density_with_the_measurement_noise(dof, density):
    """(11) is the limit without tails; S without R, as printed in (10), would have a large error."""
    three, residual = filters(), np.array([[0.1, 0.2], [0.3, -0.1], [0.0, 0.5]])
    noise = np.array([[0.04, 0.01], [0.01, 0.02]])
    spread = three.covariance[0, :2, :2] + noise
    extra = {"df": dof} if density == "multivariate_t" else {}
    found, _ = score(three, residual, noise, dof)
    assert found == pytest.approx(
        [getattr(scipy.stats, density).logpdf(r, np.zeros(2), spread, **extra) for r in residual], rel=1e-5
    )


def test_noise_is_increased_for_a_jump_that_no_model_predicts():
    three, noise = filters(), np.eye(2) * 0.01
    near, far = np.zeros((3, 2)), np.full((3, 2), 3.0)
    assert score(three, near, noise, 4.0)[1] == 1.0
    one_does = np.concatenate([far[:2], near[:1]])
    assert score(three, one_does, noise, 4.0)[1] == 1.0
    assert score(three, far, noise, 4.0)[1] == pytest.approx((4 + 18 / 0.02) / 6)


@pytest.mark.parametrize("speed", [0.0, 0.4, 5.0])
def test_transitions_are_probabilities_and_only_slow_vehicles_become_stationary(speed):
    chain = transitions(filters(speed), DT, CONFIG)
    assert chain.sum(axis=1) == pytest.approx(1.0)
    assert (chain >= 0).all()
    if speed == 5.0:
        assert chain[CV, STATIONARY] == pytest.approx(0.0, abs=1e-8)
    if speed == 0.0:
        assert chain[CV, STATIONARY] > 0.3


def test_mixing_keeps_the_moments_of_the_mixture():
    """The mixture has the same mean and covariance before and after mixing."""
    rng = np.random.default_rng(2)
    root = rng.normal(size=(3, 6, 6))
    three = Filters(rng.normal(size=(3, 6)), root @ root.swapaxes(1, 2))
    probability = np.array([0.2, 0.5, 0.3])
    chain = transitions(three, DT, CONFIG)
    mixed, prior = mix(three, probability, chain)

    def moments(filters, weight):
        mean = weight @ filters.mean
        off = filters.mean - mean
        return mean, np.einsum("m,mij->ij", weight, filters.covariance + off[:, :, None] * off[:, None, :])

    assert prior == pytest.approx(probability @ chain)
    for after, before in zip(moments(mixed, prior), moments(three, probability), strict=True):
        assert after == pytest.approx(before)


def drive(acceleration, method="mma", seed=1, noise_m=0.02):
    """Follow a car that drives at 10 m/s and has accelerations (K,) along x.

    Returns the errors (K,) of the estimate, those of the constant velocity filter, and the models (K,).
    """
    rng, config = np.random.default_rng(seed), MmaConfig(method=method)
    bank = OneBank(R, mma=config)
    x, speed, errors, cv_errors, models = 0.0, 10.0, [], [], []
    for a in acceleration:
        x, speed = x + speed * DT + 0.5 * a * DT**2, speed + a * DT
        bank.predict(motion(DT, FilterConfig()))
        z = np.array([x, 0.0]) + rng.normal(0, noise_m, 2)
        bank.observe(z - bank.filters.mean[:, :2], R)
        errors.append(bank.estimate[0][0] - x)
        cv_errors.append(bank.filters.mean[CV, 0] - x)
        models.append(int(np.argmax(bank.probability)))
    return np.array(errors), np.array(cv_errors), np.array(models)


BRAKES = np.concatenate([np.zeros(60), np.full(40, -2.0), np.zeros(60)])


@pytest.mark.parametrize("method", ["mma", "imm"])
def test_a_manoeuvre_is_detected_and_left_quickly(method):
    *_, models = drive(BRAKES, method)
    assert np.mean(models[20:60] == CV) > 0.9
    assert np.argmax(models[60:] == CA) < 10
    assert np.argmax(models[100:] == CV) < 25


def test_mixed_filters_are_accurate_after_a_manoeuvre():
    """The mixed constant velocity filter has an error of centimetres after braking."""
    off = {method: np.abs(drive(BRAKES, method)[1][95:105]).mean() for method in ("mma", "imm", "paper")}
    assert max(off["mma"], off["imm"]) < 0.5 * off["paper"]


def test_imm_and_mma_agree_if_one_model_is_certain():
    imm, mma_ = drive(np.zeros(80), "imm")[0], drive(np.zeros(80), "mma")[0]
    assert imm[30:] == pytest.approx(mma_[30:], abs=0.01)


def test_a_distant_measurement_leaves_finite_probabilities():
    for method in ("mma", "imm", "paper"):
        bank = OneBank(R, mma=MmaConfig(method=method))
        bank.predict(motion(DT, FilterConfig()))
        bank.observe(np.full((3, 2), 1e4), R)
        assert np.isfinite(bank.probability).all()
        assert bank.probability.sum() == pytest.approx(1.0)


def test_the_papers_bank_equals_filterpy_and_the_batch():
    """`paper` runs filterpy's objects, `average` the batch; without mixing their filters are equal for forty scans."""
    rng, config, step = np.random.default_rng(3), FilterConfig(), motion(DT, FilterConfig())
    banks = [OneBank(R, config, MmaConfig(method=method)) for method in ("paper", "average")]
    for k in range(40):
        z = np.array([0.5 * k, 0.02 * k * k]) + rng.normal(0.0, 0.05, 2)
        for bank in banks:
            bank.predict(step)
            bank.observe(z - bank.filters.mean[:, :2], R)
    paper, batch = banks
    assert paper.filters.mean == pytest.approx(batch.filters.mean, abs=1e-9)
    assert paper.filters.covariance == pytest.approx(batch.filters.covariance, abs=1e-9)
    assert paper.probability == pytest.approx(batch.probability, abs=1e-9)
    best = np.argmax(paper.probability)
    assert paper.estimate[0] == pytest.approx(batch.filters.mean[best])
    assert paper.weights == pytest.approx(np.eye(3)[best])


def test_the_average_is_the_mean_of_the_mixture():
    bank = OneBank(R, mma=MmaConfig(method="average"))
    for k in range(6):
        bank.predict(motion(DT, FilterConfig()))
        bank.observe(np.array([0.4 * k, 0.0]) - bank.filters.mean[:, :2], R)
    mean, covariance = bank.estimate
    expected = bank.probability @ bank.filters.mean
    off = bank.filters.mean - expected
    assert mean == pytest.approx(expected)
    by_hand = sum(
        p * (c + np.outer(d, d)) for p, c, d in zip(bank.probability, bank.filters.covariance, off, strict=True)
    )
    assert covariance == pytest.approx(by_hand)


def test_transitions_remain_probabilities_after_a_long_gap():
    chain = transitions(filters(0.0), 3.0, CONFIG)
    assert chain.sum(axis=1) == pytest.approx(1.0)
    assert (chain >= 0.0).all()


@pytest.mark.parametrize("method", ["mma", "average", "paper"])
def test_a_single_model_is_a_bank(method):
    bank = OneBank(R, FilterConfig(models=("cv",)), MmaConfig(method=method))
    bank.predict(motion(DT, FilterConfig(models=("cv",))))
    bank.observe(np.array([[0.4, 0.0]]), R)
    assert bank.probability == pytest.approx([1.0])


def test_an_interacting_multiple_model_needs_two_models():
    with pytest.raises(ValueError, match="needs two models or more"):
        TrackerConfig(filters=FilterConfig(models=("cv",)), mma=MmaConfig(method="imm"))


@pytest.mark.parametrize("method", ["mma", "imm", "average", "paper"])
@pytest.mark.parametrize("models", [("cv", "ca"), ("stationary", "cv", "ca", "ctrv", "ctra", "two-axle")])
def test_any_set_of_models_follows_a_car(method, models):
    """A car at 10 m/s; every set has a model of it."""
    config, rng = FilterConfig(models=models), np.random.default_rng(2)
    bank = OneBank(R, config, MmaConfig(method=method))
    for k in range(1, 60):
        bank.predict(motion(DT, config))
        bank.observe(np.array([10.0 * DT * k, 0.0]) + rng.normal(0.0, 0.02, 2) - bank.filters.mean[:, :2], R)
    assert bank.estimate[0][2] == pytest.approx(10.0, abs=0.5)
    assert bank.probability.shape == (len(models),)
    assert bank.weights.sum() == pytest.approx(1.0)


@pytest.mark.parametrize("models", [(), ("cv", "cv")])
def test_a_set_of_models_names_each_once(models):
    with pytest.raises(ValueError, match="name one model or more, each once"):
        FilterConfig(models=models)


def test_invalid_settings_are_rejected_by_name():
    with pytest.raises(ValueError, match="mode_time_s"):
        MmaConfig(mode_time_s=0.1)


@pytest.mark.parametrize("method", ["mma", "imm"])
def test_an_inflated_position_is_corrected_without_changing_the_speed(method):
    """A corner error of half a metre is not motion: with the usual variance the filters estimate several m/s."""
    config = MmaConfig(method=method, tail_dof=1e9)
    followed = OneBank(R, mma=config)
    step = motion(DT, FilterConfig())
    for k in range(20):
        followed.predict(step)
        followed.observe(np.array([8.0 * DT * (k + 1), 0.0]) - followed.filters.mean[:, :2], R)
    followed.predict(step)
    followed.table.covariance[0, :, :2, :2] += np.eye(2) * 0.5**2
    before = followed.filters.mean.copy()
    followed.observe(np.array([0.5, 0.0]) + before[CV, :2] - before[:, :2], R)
    change = (followed.filters.mean - before)[CV]
    assert change[0] == pytest.approx(0.5, abs=0.01)
    assert abs(change[2]) < 0.1
