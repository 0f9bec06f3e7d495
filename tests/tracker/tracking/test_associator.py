"""Rounds of association, by the status of the tracks."""

import pytest
from support.one_track import joined, start
from support.seen import observe_boxes

from luxloop.tracker.records import Status
from luxloop.tracker.tracking.association import AssociationConfig, HungarianAssociator
from luxloop.tracker.tracking.hypotheses import HypothesisConfig, Predictions, hypothesise

PLACE = (20.0, 6.0, 0.0)


def pairs(tracks, seen):
    """Return the pairs of tracks and boxes."""
    tracks = joined(tracks)
    expected = Predictions.of(tracks)
    return HungarianAssociator(AssociationConfig()).associate(
        tracks, expected, hypothesise(expected, seen, HypothesisConfig()), seen
    )


@pytest.mark.parametrize(
    ("status", "expected"),
    [
        (Status.TENTATIVE, [(0, 0)]),
        (Status.CONFIRMED, [(0, 0)]),  # by an oracle, or a track management that confirms at once
        (Status.COASTING, [(0, 0)]),
        (Status.DEAD, []),
    ],
)
def test_a_living_track_of_any_status_gets_its_second_box(status, expected):
    track = start(PLACE)
    track.table.status[0] = status
    assert pairs([track], observe_boxes(PLACE, (4.7, 1.8))) == expected


def test_of_two_tracks_in_one_place_the_one_with_more_observations_gets_the_box():
    """A confirmed track that was seen once comes after a tentative one that was seen twice."""
    new, old = start(PLACE), start(PLACE)
    new.table.status[0], old.table.hits[0] = Status.CONFIRMED, 2
    assert pairs([new, old], observe_boxes(PLACE, (4.7, 1.8))) == [(1, 0)]
