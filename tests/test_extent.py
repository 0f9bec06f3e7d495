import numpy as np
import pytest

from tracker.extent import ExtentConfig, classify, complete, known, remember

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
    ("extent", "hits", "size"),
    [
        ((0.1, 1.72), 50, (4.7, 1.8)),
        ((2.9, 1.9), 50, (4.7, 1.9)),
        ((4.05, 0.1), 1, (4.05 + 0.3, 1.8)),  # the far corner is rounded
        ((0.1, 2.5), 1, (8.0, 2.5)),
        ((11.9, 0.1), 1, (11.9 + 0.1, 2.5)),
        ((1.9, 0.7), 1, (4.7, 1.8)),  # may be a piece of a car
        ((1.9, 0.7), 50, (1.9, 0.8)),  # a motorcycle
    ],
)
def test_unseen_sides_come_from_the_class(extent, hits, size):
    seen_extent = np.array(extent)
    assert complete(seen_extent, classify(seen_extent, hits, CONFIG), CONFIG) == pytest.approx(size)


def test_a_side_is_known_once_nearly_all_of_it_was_seen():
    size = np.array([4.5, 1.8])
    assert known(np.array([4.2, 0.3]), size, CONFIG) == pytest.approx([4.5, 0.3])
