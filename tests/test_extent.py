import numpy as np
import pytest

from tracker.extent import ExtentConfig, complete, remember

CONFIG = ExtentConfig()


def seen(*observations):
    extent = np.array(observations[0], dtype=float)
    for observed in observations[1:]:
        extent = remember(extent, np.array(observed, dtype=float), CONFIG)
    return extent


def test_a_side_once_seen_is_not_forgotten_behind_an_occluder():
    assert seen((4.5, 1.7), *[(1.0, 1.7)] * 200)[0] == 4.5


def test_longer_sights_pull_and_settle():
    assert seen((2.0, 1.7), *[(4.8, 1.7)] * 30)[0] == pytest.approx(4.8, abs=0.01)


def test_a_single_outlier_wears_off():
    assert seen((4.5, 1.7), (5.5, 1.7), *[(4.5, 1.7)] * 400)[0] == pytest.approx(4.5, abs=0.02)


@pytest.mark.parametrize(
    ("extent", "size"),
    [
        ((0.1, 1.72), (CONFIG.car_length_m, CONFIG.car_width_m)),
        ((4.05, 0.1), (4.05 + CONFIG.car_rounding_m, CONFIG.car_width_m)),
        ((2.9, 1.9), (CONFIG.car_length_m, 1.9)),
        ((0.1, 2.5), (CONFIG.large_length_m, 2.5)),
        ((11.9, 0.1), (11.9 + CONFIG.large_rounding_m, CONFIG.large_width_m)),
    ],
)
def test_unseen_sides_come_from_the_class(extent, size):
    assert complete(np.array(extent), CONFIG) == pytest.approx(size)
