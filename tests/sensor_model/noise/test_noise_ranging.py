"""Reported ranges: statistics of their errors."""

from dataclasses import replace

import numpy as np
import pytest
import scipy
from support.noise_scenes import ALL, BEAMS, within

from luxloop.sensor_model.noise.noise_config import NoiseConfig, Outliers, RangeNoise
from luxloop.sensor_model.noise.random_draws import Draws
from luxloop.sensor_model.noise.ranging import echo_places, measure_ranges, measure_widths

REAL = np.ones(len(ALL), np.bool_)
TWENTY = np.full(len(ALL), 20.004)
EXACT = NoiseConfig(range=RangeNoise(enabled=False))
SMOOTH = replace(BEAMS, units=replace(BEAMS.units, range_quantum=np.full(6, 1e-9)))


def errors(config, frames=(0, 1, 2, 3), beams=BEAMS, at=20.004):
    draws, ranges = Draws(3, beams), np.full(len(ALL), at)
    return np.array(
        [
            measure_ranges(ALL, ranges, echo_places(ranges), REAL, beams, config, draws, frame).range - at
            for frame in frames
        ]
    )


@pytest.mark.parametrize("first", [0, 100_000])
def test_range_error_has_the_units_sigma_and_the_bias_of_each_layer(first):
    """1.53 cm at 20 m and the LUX's biases; a quantum of 1 cm adds 1/12 of its square to the variance.

    After 1e5 frames too."""
    all_errors = errors(NoiseConfig(), range(first, first + 4))
    for layer, bias in enumerate([-0.015, 0.004, 0.009, 0.002]):
        of_layer = all_errors[:, BEAMS.layer == layer]
        assert of_layer.mean() == pytest.approx(bias, abs=4 * 0.01534 / np.sqrt(of_layer.size))
        assert of_layer.std() == pytest.approx(np.sqrt(0.01534**2 + 0.01**2 / 12), rel=4 / np.sqrt(2 * of_layer.size))


def test_range_error_is_normal():
    config = NoiseConfig(range=RangeNoise(sigma_scale=2.0, layer_bias_scale=0.0))
    assert (
        scipy.stats.kstest(errors(config, beams=SMOOTH).ravel(), scipy.stats.norm(0.0, 2 * 0.01534).cdf).pvalue > 1e-3
    )


@pytest.mark.parametrize(
    ("at", "sigma"), [(1.3, 0.015), (25.0, 0.01581), (40.0, 0.01972), (50.0, 0.025), (90.0, 0.025)]
)
def test_noise_grows_with_the_range(at, sigma):
    """1.5^2 + (2.5^2 - 1.5^2) (r / 50)^4 cm^2 up to 50 m: at 25 m 2.25 + 4 / 16 = 2.5, at 40 m 2.25 + 1.638 = 3.89."""
    some = errors(NoiseConfig(range=RangeNoise(layer_bias_scale=0.0)), beams=SMOOTH, at=at)
    assert some.std() == pytest.approx(sigma, rel=4 / np.sqrt(2 * some.size))


def test_layer_bias_scales_and_is_zero_on_average():
    assert sum(BEAMS.layer_bias[BEAMS.layer == layer][0] for layer in range(4)) == pytest.approx(0.0, abs=1e-12)
    error = errors(NoiseConfig(range=RangeNoise(sigma_scale=0.0, layer_bias_scale=2.0)), (0,), SMOOTH)[0]
    assert error[BEAMS.layer == 2] == pytest.approx(0.018)


def test_ranges_are_multiples_of_the_quantum():
    reported_cm = 100.0 * (20.004 + errors(NoiseConfig()))
    assert np.abs(reported_cm - np.round(reported_cm)).max() < 1e-6


def test_ranges_are_exact_without_noise():
    assert np.all(errors(EXACT) == 0.0)


def test_echoes_of_a_beam_have_independent_errors():
    """Fails if an echo's error depends on the other echoes of its beam, for example by its index."""
    draws, two = Draws(3, SMOOTH), np.repeat(ALL, 2)
    ranges = np.tile([20.0, 21.4], len(ALL))
    both = (
        measure_ranges(two, ranges, echo_places(ranges), np.repeat(REAL, 2), SMOOTH, NoiseConfig(), draws, 5).range
        - ranges
    )
    second = np.full(len(ALL), 21.4)
    second_alone = measure_ranges(ALL, second, echo_places(second), REAL, SMOOTH, NoiseConfig(), draws, 5).range - 21.4
    assert np.array_equal(both[1::2], second_alone)
    bias = BEAMS.layer_bias
    assert abs(np.corrcoef(both[::2] - bias, both[1::2] - bias)[0, 1]) < 4.5 / np.sqrt(len(ALL))


def test_ranges_stay_within_the_limits_of_the_unit():
    """Fails if noise puts a point behind its unit."""
    near, far = np.full(len(ALL), 0.31), np.full(len(ALL), 199.99)
    config = NoiseConfig(range=RangeNoise(sigma_scale=10.0), outliers=Outliers(True, rate=0.5, scale_m=5.0))
    for true_range in (near, far):
        range_ = measure_ranges(ALL, true_range, echo_places(true_range), REAL, BEAMS, config, Draws(3, BEAMS), 0).range
        assert range_.min() >= 0.3
        assert range_.max() <= 200.0


def test_outliers_have_their_rate_and_a_laplace_distribution():
    config = replace(EXACT, outliers=Outliers(True, rate=0.05, scale_m=0.8))
    some = [
        measure_ranges(ALL, TWENTY, echo_places(TWENTY), REAL, BEAMS, config, Draws(3, BEAMS), frame)
        for frame in range(10)
    ]
    outlier = np.concatenate([each.outlier for each in some])
    error = np.concatenate([each.range for each in some]) - 20.004
    assert within(outlier.sum(), len(outlier), 0.05)
    assert np.all(error[~outlier] == 0.0)
    assert scipy.stats.kstest(error[outlier], scipy.stats.laplace(0.0, 0.8).cdf).pvalue > 1e-3


def test_outliers_do_not_change_other_errors():
    """Fails if both kinds share a sequence of draws."""
    draws = Draws(3, BEAMS)
    before = measure_ranges(ALL, TWENTY, echo_places(TWENTY), REAL, BEAMS, NoiseConfig(), draws, 5)
    after = measure_ranges(
        ALL, TWENTY, echo_places(TWENTY), REAL, BEAMS, NoiseConfig(outliers=Outliers(True, rate=0.1)), draws, 5
    )
    assert not before.outlier.any()
    assert 300 < after.outlier.sum() < 700
    assert np.array_equal(before.range[~after.outlier], after.range[~after.outlier])


def test_only_echoes_of_surfaces_have_gross_errors():
    """Fails if a drop or a ghost gets a gross error, or changes the draws of others."""
    draws, real = Draws(3, BEAMS), ALL % 2 == 0
    config = replace(EXACT, outliers=Outliers(True, rate=0.1))
    every, some = (measure_ranges(ALL, TWENTY, echo_places(TWENTY), of, BEAMS, config, draws, 5) for of in (REAL, real))
    assert every.outlier[~real].sum() > 100
    assert np.array_equal(some.outlier, every.outlier & real)
    assert np.all(some.range[~real] == 20.004)
    assert np.array_equal(some.range[real], every.range[real])


def test_rounding_keeps_ranges_within_the_limits():
    """In multiples of 0.7 m the limits 0.3 m and 200 m become 0 and 200.2 m. Fails if ranges are clipped before."""
    coarse = replace(BEAMS, units=replace(BEAMS.units, range_quantum=np.full(6, 0.7)))
    for true_range in (0.3, 200.0):
        at = np.full(len(ALL), true_range)
        of = measure_ranges(ALL, at, echo_places(at), REAL, coarse, NoiseConfig(), Draws(3, BEAMS), 0)
        assert of.range.min() >= 0.3
        assert of.range.max() <= 200.0


def test_no_ranges_without_returns():
    none = np.empty(0, np.int64)
    config = NoiseConfig(outliers=Outliers(True))
    result = measure_ranges(none, none.astype(float), none, none.astype(bool), BEAMS, config, Draws(3, BEAMS), 0)
    assert len(result.range) == len(result.outlier) == 0


def widths(config, true_width=2.0, frame=0):
    width = np.full(len(ALL), true_width)
    return measure_widths(ALL, echo_places(TWENTY), width, BEAMS, config, Draws(3, BEAMS), frame)


def test_width_error_has_the_units_sigma_and_the_bias_of_each_layer():
    all_widths = np.array([widths(NoiseConfig(), frame=frame) for frame in range(4)])
    for layer, bias in enumerate([0.15, 0.31, -0.31, -0.15]):
        of_layer = all_widths[:, BEAMS.layer == layer]
        assert of_layer.mean() == pytest.approx(2.0 + bias, abs=4 * 0.09 / np.sqrt(of_layer.size))
        assert of_layer.std() == pytest.approx(np.sqrt(0.09**2 + 0.04**2 / 12), rel=4 / np.sqrt(2 * of_layer.size))


def test_widths_are_multiples_of_the_quantum_and_at_least_one():
    for true_width in (2.0, 0.1):
        quanta = widths(NoiseConfig(), true_width) / 0.04
        assert np.abs(quanta - np.round(quanta)).max() < 1e-6
        assert quanta.min() >= 1.0 - 1e-9


def test_widths_are_rounded_only_without_noise():
    assert widths(EXACT, 1.99) == pytest.approx(2.0)


def test_errors_of_range_and_width_are_independent():
    layers = BEAMS.layer == 0
    range_error, width = errors(NoiseConfig(), (0,), SMOOTH)[0][layers], widths(NoiseConfig())[layers]
    assert abs(np.corrcoef(range_error, width)[0, 1]) < 4.5 / np.sqrt(layers.sum())
