"""Posterior of vehicle sizes against scipy's distributions and sums by hand, and the sizes that views imply."""

import numpy as np
import pytest
from scipy import stats

from luxloop.tracker.records import MODELS
from luxloop.tracker.tracking import vehicle_size
from luxloop.tracker.tracking.track_table import empty
from luxloop.tracker.tracking.vehicle_size import (
    HIDDEN_STD_M,
    LOG_ODDS_MAX,
    MARGIN_M,
    SIZE_STD_FRACTION,
    WHOLE_FRACTION,
    add_view,
    average_pieces,
    extend_size,
    first_view,
    likely,
    observe_size,
    posterior,
    side_of_greatest_overlap,
    swap_sides,
)
from luxloop.tracker.vehicle_classes import GRID_M, SIZE_CLASSES, side_probabilities

WHOLE, CUT = (True, True), (False, False)


class OneSize:
    """The size of a table of one track."""

    def __init__(self, size, whole):
        self._table = table = empty(MODELS, rows=1)
        columns = table.size_likelihood, table.piece_likelihood, table.size_views, table.size, table.size_std
        for column, value in zip(columns, first_view(np.asarray(size, dtype=float), whole), strict=True):
            column[0] = value
        table.visible_size[0] = size

    def observe(self, size, whole):
        observe_size(self._table, 0, np.asarray(size, dtype=float), whole)

    def extend(self, seen):
        extend_size(self._table, 0, seen)

    def swap(self):
        swap_sides(self._table, 0)

    @property
    def size(self):
        return self._table.size[0]

    @property
    def std(self):
        return self._table.size_std[0]

    @property
    def seen(self):
        return self._table.visible_size[0]

    @property
    def known(self):
        return self._table.known_size[0]

    @property
    def whole_views(self):
        return self._table.whole_views[0]


def size_after(*views):
    """Estimated size after views ((length, width), mask of whole sides)."""
    first, *others = [(np.array(extents, dtype=float), np.array(whole)) for extents, whole in views]
    estimator = OneSize(*first)
    for view in others:
        estimator.observe(*view)
    return estimator.size


def test_a_view_of_a_whole_side_has_the_likelihood_of_its_mixture():
    log_likelihood = np.zeros((2, len(GRID_M)))
    weight, none = np.array([1.0, 0.0]), np.zeros(2)
    add_view(log_likelihood, np.array([4.0, 1.6]), np.array(WHOLE), weight, none, np.array([0.3, 0.1]))
    seen = stats.norm(GRID_M - 0.3, np.hypot(HIDDEN_STD_M, SIZE_STD_FRACTION * GRID_M)).pdf(4.0)
    piece = stats.uniform(0.0, GRID_M).pdf(4.0 - MARGIN_M * (GRID_M < 4.0))
    expected = np.log(0.7 * seen + 0.3 * np.where(GRID_M > 4.0 - MARGIN_M, piece, 0.0) + 0.05 / GRID_M[-1])
    expected = np.maximum(expected - expected.max(), -LOG_ODDS_MAX)
    assert log_likelihood[0] == pytest.approx(expected, abs=1e-9)
    assert not log_likelihood[1].any(), "a side without weight is not visible"


def test_truncated_views_are_averaged():
    """A hundred views of a vehicle that stands still have the evidence of one, with the likelihood of its mixture."""
    mean, hidden = np.zeros((2, len(GRID_M))), np.array([0.3, 0.1])
    for count in range(1, 101):
        average_pieces(mean, np.array([4.0, 1.6]), np.array([1.0 / count, 0.0]), hidden)
    seen = stats.norm(GRID_M - 0.3, np.hypot(HIDDEN_STD_M, SIZE_STD_FRACTION * GRID_M)).pdf(4.0)
    piece = (GRID_M > 4.0 - MARGIN_M) / GRID_M
    expected = np.log((1.0 - WHOLE_FRACTION) * piece + WHOLE_FRACTION * seen + 0.05 / GRID_M[-1])
    assert mean[0] == pytest.approx(expected, abs=1e-9)
    assert not mean[1].any()


def test_a_side_between_two_gaps_of_units_has_its_length():
    """A lorry beside the ego, both of whose ends are in gaps, counts as truncated in every view."""
    assert size_after(*[((7.7, 2.3), (False, True))] * 50)[0] == pytest.approx(8.0, abs=0.9)


def test_without_views_the_posterior_is_the_mixture_of_the_classes():
    share, prior = side_probabilities()
    probability = posterior(np.ones((2, len(GRID_M))), share, prior)
    assert probability.sum(axis=1) == pytest.approx([1.0, 1.0])
    assert probability == pytest.approx(np.einsum("c,cag->ag", share, prior))
    long = probability[0, GRID_M > 6.5].sum()
    of_lorries = SIZE_CLASSES[2].share * (12.4 - 6.5) / (12.4 - 5.9) + SIZE_CLASSES[3].share
    assert long == pytest.approx(of_lorries, abs=0.01)


def test_a_class_excluded_by_its_width_gives_no_length():
    """Bayes' rule by hand for two classes: the width has odds of 1 to 4 for them, and so have their lengths."""
    prior = np.zeros((2, 2, len(GRID_M)))
    prior[0, 0, 120], prior[0, 1, 70] = 1.0, 1.0
    prior[1, 0, 180], prior[1, 1, 90] = 1.0, 1.0
    likelihood = np.ones((2, len(GRID_M)))
    likelihood[1, 70] = 0.25
    probability = posterior(likelihood, np.array([0.5, 0.5]), prior)
    assert probability[0, [120, 180]] == pytest.approx([0.2, 0.8])


@pytest.mark.parametrize(("first", "weight"), [(110, 0.5), (60, 0.9), (150, 0.2)])
def test_the_side_of_greatest_overlap_is_found_by_trying_all(first, weight):
    probability = np.zeros(len(GRID_M))
    probability[first : first + 10], probability[first + 40] = weight / 10, 1.0 - weight
    overlap = np.minimum.outer(GRID_M, GRID_M) / np.maximum.outer(GRID_M, GRID_M)
    best = GRID_M[np.argmax(overlap @ probability)]
    assert side_of_greatest_overlap(probability) == pytest.approx(best, rel=0.05)


@pytest.mark.parametrize(
    ("views", "size"),
    [
        ([((0.1, 1.65), WHOLE)] * 5, (4.5, 1.82)),  # the rear of a car
        ([((2.5, 0.1), CUT)] * 5, (4.5, 1.82)),  # a piece of its side
        ([((3.7, 1.6), WHOLE)] * 5, (3.97, 1.77)),  # a small car
        ([((5.6, 1.85), WHOLE)] * 5, (5.87, 2.0)),  # a van
        ([((0.1, 2.4), WHOLE)] * 5, (11.0, 2.53)),  # a lorry from behind: 6 to 18.75 m
        ([((11.7, 0.1), WHOLE)] * 5, (12.0, 2.5)),  # a bus
        ([((0.1, 0.65), WHOLE)] * 5, (2.11, 0.8)),  # a motorcycle from behind
    ],
)
def test_sizes_of_usual_views(views, size):
    length, width = size_after(*views)
    assert length == pytest.approx(size[0], rel=0.15 if size[0] > 6.0 else 0.05)
    assert width == pytest.approx(size[1], abs=0.1)


def test_a_length_recovers_from_a_merged_neighbour_within_two_seconds():
    views = [((3.8, 1.6), WHOLE)] * 10 + [((10.0, 1.6), CUT)] * 50
    assert size_after(*views, *[((3.8, 1.6), WHOLE)] * 25)[0] == pytest.approx(4.07, abs=0.1)


def test_a_seen_side_keeps_its_length_while_it_faces_away():
    side = [((4.4, 1.6), WHOLE)] * 10
    assert size_after(*side, *[((0.1, 1.6), WHOLE)] * 500)[0] == pytest.approx(size_after(*side)[0], abs=0.01)


def test_pieces_of_one_vehicle_have_its_length():
    estimator = OneSize(np.array([4.0, 2.3]), np.array(WHOLE))
    for _ in range(20):
        estimator.observe(np.array([4.0, 2.3]), np.array(WHOLE))
    estimator.extend(np.array([14.0, 2.4]))
    assert estimator.size[0] > 13.9
    assert likely(estimator.seen, estimator.size, estimator.std)[0] > 13.9


def test_a_quarter_turn_renames_the_sides():
    views = [((1.7, 4.3), WHOLE)] * 5
    estimator = OneSize(np.array(views[0][0]), np.array(WHOLE))
    for extents, whole in views[1:]:
        estimator.observe(np.array(extents), np.array(whole))
    estimator.swap()
    assert estimator.size == pytest.approx(size_after(*[((4.3, 1.7), WHOLE)] * 5), abs=0.12)  # hidden parts differ
    assert estimator.seen == pytest.approx([4.3, 1.7])


@pytest.mark.parametrize(
    "sides",
    [
        [((4.3, 1.7), (True, False))] * 4,
        [((4.3, 1.7), (False, True))] * 4,
        [((2.0, 1.7), (False, True))] * 4 + [((3.0, 0.2), (False, True))] * 3,
        [((0.1, 1.7), WHOLE)] * 6,
    ],
    ids=["length whole", "width whole", "length in pieces", "length faces away"],
)
def test_a_quarter_turn_renames_all_that_is_known_of_the_sides(sides, monkeypatch):
    """Later views have the same effect as if the first ones had had the names of the sides from the start."""
    monkeypatch.setattr(vehicle_size, "HIDDEN_M", np.array([0.2, 0.2]))
    renamed, named = (OneSize(*map(np.array, view)) for view in (turned(sides[0]), sides[0]))
    for view in sides[1:]:
        renamed.observe(*map(np.array, turned(view)))
        named.observe(*map(np.array, view))
    renamed.swap()
    for view in [((4.6, 1.9), WHOLE), ((4.0, 1.5), CUT), ((4.4, 1.8), WHOLE)]:
        for of in ("seen", "whole_views", "size", "std", "known"):
            assert getattr(renamed, of) == pytest.approx(getattr(named, of), abs=1e-9), of
        renamed.observe(*map(np.array, view))
        named.observe(*map(np.array, view))


def turned(view):
    """Return a view with its sides named across and along."""
    extents, whole = view
    return extents[::-1], whole[::-1]
