"""Merging of the tracks of pieces: several pieces together stay within the length of a vehicle."""

import numpy as np
from support.one_track import CONFIG, DT, MMA, follow, joined, start

from luxloop.tracker.merging import MergeConfig
from luxloop.tracker.records import Status
from luxloop.tracker.tracking.model_selection import model_selection
from luxloop.tracker.tracking.track_management import DefaultTrackManagement

SPEED_MPS, PIECE_M, PITCH_M = 20.0, np.array([6.0, 2.5]), 8.0
"""Pieces of 6 m with gaps of 2 m: two are 14 m long, three 22 m."""


def piece(track_id, x, frames):
    """A confirmed track of a piece that ends at `x` after its frames."""
    places = [(x - SPEED_MPS * DT * before, 5.0, 0.0) for before in range(frames, -1, -1)]
    track = start(places[0], size=PIECE_M)
    follow(track, places[1:], size=PIECE_M)
    track.table.id[0], track.table.status[0] = track_id, Status.CONFIRMED
    return track


def test_a_piece_takes_one_neighbour_but_not_both():
    """The middle one is the oldest and fits either of the others."""
    tracks = joined([piece(0, 0.0, 30), piece(1, PITCH_M, 20), piece(2, -PITCH_M, 20)])
    management = DefaultTrackManagement(MergeConfig(), CONFIG)
    management.merge(tracks, np.arange(3), model_selection(MMA))
    assert (tracks.status == Status.DEAD).sum() == 1
    assert tracks.status[0] == Status.CONFIRMED
    assert 13.0 < tracks.visible_size[0, 0] < 15.0
