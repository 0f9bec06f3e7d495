"""Confirmation of tracks: shape and motion of vehicles and of background."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from support.one_track import DT, flow_of, follow, start, straight

from luxloop.tracker.records import MODELS, Status
from luxloop.tracker.tracking import confirmation as confirmation_module
from luxloop.tracker.tracking.confirmation import (
    FLAT_LOG_ODDS,
    MOTION_LOG_ODDS,
    VEHICLE_LOG_ODDS_MAX,
    VIEW_LOG_ODDS_MAX,
    ConfirmationConfig,
    count_view,
    reacquire,
    vehicle_odds,
    view_log_odds,
)
from luxloop.tracker.tracking.track_table import empty
from luxloop.tracker.vehicle_classes import CLASSES

WHOLE = (True, True)
FLAT = 0.03
"""Depth of a flat segment with range noise [m]."""
FRONT_CUT, BOTH_CUT = (True, False, False, False), (True, False, True, False)


class View(NamedTuple):
    """A view of an object along x."""

    size: np.ndarray
    whole: np.ndarray
    exact: np.ndarray
    flat: bool
    sign: np.ndarray


def view(size, whole=WHOLE, exact=WHOLE, flat=False, sign=(-1, -1)):
    return View(np.array(size), np.array(whole), np.array(exact), flat, np.array(sign))


class Judge:
    """A table of one track whose visible part is centred at its tracked corner, with its confirmation."""

    def __init__(self, size=(4.6, 1.8), heading=0.0, **values):
        self._config, self._table = ConfirmationConfig(**values), empty(MODELS, rows=1)
        self._table.prior_log_odds[0] = confirmation_module.log_odds(self._config.vehicle_prior)
        self._table.yaw[0, 0], self._table.visible_size[0] = heading, size

    def count(self, seen):
        count_view(self._table, 0, seen.size, seen.whole, seen.flat)

    def leave(self):
        self._table.left[0] = True

    @property
    def moved_before_hidden(self):
        return bool(self._table.moved_before_hidden[0])

    def reacquire(self, same):
        reacquire(self._table, 0, same, self._config)

    @property
    def log_odds(self):
        return vehicle_odds(self._table, 0)


def confirmation(size=(4.6, 1.8), **values):
    return Judge(size, **values)


def log_odds(seen, views, **values):
    """Return the log-odds after equal views."""
    judged = confirmation(**values)
    for _ in range(views):
        judged.count(seen)
    return judged.log_odds


# --- evidence


@pytest.mark.parametrize(("views", "equal_to"), [(0, 0.0), (1, 1.0), (2, 2 / 1.2), (6, 3.0), (1000, 1000 / 200.8)])
def test_correlated_views_have_the_evidence_of_a_few(views, equal_to):
    """With a correlation of 0.2, n views have that of n / (0.8 + 0.2 n), at most 5. A class's share counts once."""
    seen = view((2.2, 1.0))
    one = view_log_odds(seen.size, seen.whole, seen.flat)
    assert 0.5 < one[0] < 2.0
    of_class = [kind.share * math.exp(equal_to * odds) for kind, odds in zip(CLASSES, one, strict=True)]
    assert log_odds(seen, views) == pytest.approx(math.log(sum(of_class)), abs=1e-12)


@pytest.mark.parametrize(("prior", "expected"), [(0.5, 0.0), (0.9, math.log(9.0)), (0.2, -math.log(4.0))])
def test_without_evidence_the_prior_holds(prior, expected):
    assert confirmation(vehicle_prior=prior).log_odds == pytest.approx(expected)


def test_the_evidence_of_one_view_is_limited(monkeypatch):
    """A car in full view, surely not truncated, has log-odds above 3 for cars and below -2 for other classes: together
    ln(0.6 e^3 + 0.4 e^-2) = 2.4937. A house of 9 by 7 m is below -2 for each."""
    monkeypatch.setattr(confirmation_module, "TRUNCATED_PROBABILITY", 0.0)
    assert VEHICLE_LOG_ODDS_MAX == 3.0
    assert VIEW_LOG_ODDS_MAX == 2.0
    assert log_odds(view((4.0, 1.5)), 1) == pytest.approx(2.4937, abs=1e-4)
    assert log_odds(view((9.0, 7.0)), 1) == pytest.approx(-2.0)


def test_a_missing_side_is_evidence_against_a_vehicle():
    size, car = np.array([2.2, 0.8]), 0
    seen, lacking = (view_log_odds(size, np.array(WHOLE), flat)[car] for flat in (False, True))
    assert lacking == pytest.approx(seen - FLAT_LOG_ODDS)


def test_a_whole_car_is_above_nine_to_one_and_a_piece_is_between():
    sure = confirmation()
    sure.count(view((4.6, 1.8)))
    assert sure.log_odds > math.log(9.0)
    unsure = confirmation()
    unsure.count(view((2.2, 0.8)))
    assert unsure.log_odds < math.log(9.0)
    assert unsure.log_odds > -math.log(9.0)


def test_one_to_nine_refutes():
    """Two views of -2 have the evidence of -4 / 1.2 = -3.33, below -ln 9 = -2.20."""
    house = confirmation()
    house.count(view((9.0, 6.0)))
    assert house.log_odds > -math.log(9.0)
    house.count(view((9.0, 6.0)))
    assert house.log_odds <= -math.log(9.0)


def test_the_share_of_a_class_counts_once():
    """The flat rear of a lorry, 2.5 m wide, in plain view: of vehicles only lorries are so wide, 0.3 of which may be
    truncated. Each view says that it is twice as likely a lorry as a wall, so that many views outweigh the share."""
    rear = view((FLAT, 2.5))
    (_, _, lorry, _) = view_log_odds(rear.size, rear.whole, rear.flat)
    assert lorry > 0.0
    assert log_odds(rear, 1) < 0.0 < log_odds(rear, 50)


@pytest.mark.parametrize("length_m", [9.0, 12.0, 15.0, 18.0])
def test_a_flat_wall_as_long_as_a_lorry_is_refuted_or_stays_open(length_m):
    wall = view((length_m, 0.02))
    assert log_odds(wall, 1000) < 0.0


# --- objects that reappear


@pytest.mark.parametrize(("same", "probability"), [(0.0, 0.5), (1.0, 1.0), (0.4, 0.4 + 0.6 * 0.5)])
def test_an_object_that_reappears_has_the_probability_of_both_cases(same, probability):
    """A vehicle that was seen to move was hidden. The other object has the prior of a new track."""
    judged = confirmation()
    judged.count(view((4.6, 1.8)))
    judged.leave()
    assert judged.log_odds > MOTION_LOG_ODDS
    judged.reacquire(same)
    assert judged.moved_before_hidden
    odds = math.exp(judged.log_odds)
    assert odds / (1.0 + odds) == pytest.approx(probability, abs=1e-6)


def test_the_views_of_an_object_that_reappears_count_from_then_on():
    judged = confirmation()
    judged.count(view((9.0, 7.0)))
    judged.reacquire(0.0)
    judged.count(view((2.2, 1.0)))
    assert judged.log_odds == pytest.approx(log_odds(view((2.2, 1.0)), 1))


# --- tracks


@pytest.mark.parametrize(
    ("size", "status"),
    [
        ((12.0, 0.2), Status.TENTATIVE),  # a relief does not make a wall a bus
        ((12.0, FLAT), Status.TENTATIVE),  # may be a wall
        ((15.0, FLAT), Status.TENTATIVE),
        ((4.6, FLAT), Status.TENTATIVE),  # a flat piece of wall, as long as a car
        ((0.7, 0.1), Status.TENTATIVE),  # a pole
        ((12.0, 2.4), Status.CONFIRMED),  # walls do not have the ends of a bus
        ((4.5, 0.2), Status.CONFIRMED),  # sides of cars are bowed
        ((FLAT, 1.7), Status.TENTATIVE),  # a flat face as wide as a car
    ],
)
def test_a_single_face_of_a_stationary_object_is_confirmed_by_its_bow(size, status):
    first = (20.0, 6.0, 0.0)
    track = start(first, size=np.array(size))
    follow(track, straight(first, 0.0, 30), size=np.array(size))
    assert track.status is status


def test_a_flat_wall_of_15_m_is_never_confirmed():
    """With the noise of the fit, for 16 s."""
    first, size = (20.0, 6.0, 0.0), np.array([15.0, FLAT])
    track, rng = start(first, size=size), np.random.default_rng(2)
    for _ in range(200):
        follow(track, [first], rng, size=size)
        assert track.status is Status.TENTATIVE


def test_a_flat_side_that_was_seen_to_move_is_confirmed_by_three_observations():
    first, size = (20.0, 6.0, 0.0), np.array([12.0, FLAT])
    track = start(first, size=size)
    track.table.left[0] = True
    follow(track, straight(first, 8.0, 1), size=size)
    assert track.status is Status.TENTATIVE
    follow(track, straight((first[0] + 8.0 * DT, *first[1:]), 8.0, 1), size=size)
    assert track.status is Status.CONFIRMED


@pytest.mark.parametrize("ends", ["front", "both"])
def test_a_wall_that_comes_into_view_behind_an_occluder_is_not_in_motion(ends):
    """An occluder uncovers it at 8 m/s, or a gap of 4 m between two occluders passes it."""
    cut = FRONT_CUT if ends == "front" else BOTH_CUT
    track = start((20.0, 6.0, 0.0), size=(4.0, FLAT), cut=cut)
    for k in range(1, 20):
        grown = 8.0 * DT * k if ends == "front" else 0.0
        moved_m = 0.5 * grown if ends == "front" else 8.0 * DT * k
        follow(track, [(20.0 + moved_m, 6.0, 0.0)], size=(4.0 + grown, FLAT), cut=cut)
        assert track.status is Status.TENTATIVE


def test_a_confirmed_track_becomes_tentative_if_later_views_show_a_wall():
    """It looked like the side of a car with its glass set back; the rest of the wall comes into view."""
    first = (20.0, 6.0, 0.0)
    track = start(first, size=(4.5, 0.45))
    follow(track, [first] * 2, size=(4.5, 0.45))
    assert track.status is Status.CONFIRMED
    follow(track, [first] * 40, size=(15.0, FLAT))
    assert track.status is Status.TENTATIVE


def test_a_shape_without_a_known_axis_is_not_confirmed():
    """1.7 x 1.7 m may be either side of a vehicle: parallel to parked neighbours it is, between two hypotheses not."""
    first, size = (20.0, 6.0, 0.0), (1.7, 1.7)
    across = flow_of(forward=math.radians(45.0))
    track = start(first, across, size=size)
    follow(track, [first] * 10, size=size, flow=across)
    assert track.status is Status.TENTATIVE
    parked = flow_of((20.0, 9.0, 0.0), (20.0, 3.0, 0.0))
    follow(track, [first], size=size, flow=parked)
    assert track.status is Status.CONFIRMED


@pytest.mark.parametrize(
    ("name", "value"),
    [("confirm_probability", 0.4), ("vehicle_prior", 0.0)],
)
def test_invalid_probabilities_are_rejected_by_name(name, value):
    with pytest.raises(ValueError, match=name):
        ConfirmationConfig(**{name: value})
