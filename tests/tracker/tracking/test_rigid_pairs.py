"""Pieces of one vehicle at low speed: rigid pairs and vehicles that follow each other."""

import numpy as np
import pytest

from luxloop.tracker.merging import RigidPairs
from luxloop.tracker.records import OrientedBoxes

DT_S = 0.08
CAB_M, TRAILER_M, GAP_M = 2.0, 8.6, 2.3
SPEEDS = np.concatenate([np.zeros(20), np.linspace(0.0, 5.0, 60), np.linspace(5.0, 1.0, 40)])
"""A start from rest and a braking in a jam [m/s]."""


def pair(gap_m, speed, hits=20, turn=0.0):
    """A trailer with its front at 0, and a cab ahead of it."""
    centers = [(-0.5 * TRAILER_M, 0.0), (gap_m + 0.5 * CAB_M, 0.0)]
    return OrientedBoxes(
        center=np.array(centers),
        heading=np.array([0.0, turn]),
        size=np.array([(TRAILER_M, 0.5), (CAB_M, 2.5)]),
        velocity=np.array([(speed, 0.0), (speed, 0.0)]),
        hits=np.array([hits, hits]),
    )


def rigid_after(gaps, **options):
    """Return True if the pair is rigid after driving with `SPEEDS` and these gaps."""
    pairs = RigidPairs()
    for gap, speed in zip(gaps, SPEEDS, strict=True):
        pairs.observe([7, 4], pair(gap, speed, **options))
    return pairs.rigid(4, 7)


def test_a_cab_and_its_trailer_keep_their_gap_at_low_speed():
    noise = np.random.default_rng(3).normal(0.0, 0.05, len(SPEEDS))
    assert rigid_after(GAP_M + noise)


@pytest.mark.parametrize("headway_s", [0.5, 1.0, 1.8])
def test_the_gap_between_vehicles_grows_with_speed(headway_s):
    """Standing vehicles in queues have gaps of 2 m; half a second is the shortest headway of drivers."""
    assert not rigid_after(2.0 + headway_s * SPEEDS)


def test_a_follower_that_starts_later_is_another_vehicle():
    """The leader moves for 1.2 s before the follower reacts."""
    delay = np.concatenate([np.zeros(15), SPEEDS])[: len(SPEEDS)]
    assert not rigid_after(2.0 + np.cumsum(SPEEDS - delay) * DT_S)


def test_vehicles_that_stand_are_not_known_to_be_rigid():
    pairs = RigidPairs()
    for _ in range(200):
        pairs.observe([7, 4], pair(GAP_M, 0.0))
    assert not pairs.rigid(4, 7)


@pytest.mark.parametrize("options", [{"hits": 3}, {"turn": 0.5}], ids=["new", "bent"])
def test_pieces_that_cannot_be_one_vehicle_have_no_history(options):
    assert not rigid_after(np.full(len(SPEEDS), GAP_M), **options)


def test_a_pair_that_is_not_seen_together_starts_again():
    pairs = RigidPairs()
    for speed in SPEEDS:
        pairs.observe([7, 4], pair(GAP_M, speed))
    pairs.observe([7], OrientedBoxes(np.zeros((1, 2)), np.zeros(1), np.ones((1, 2)), np.zeros((1, 2)), np.array([50])))
    assert not pairs.rigid(4, 7)
