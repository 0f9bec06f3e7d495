"""Tracks that stand, drive and turn, with every kind of filter bank."""

import numpy as np

from luxloop.tracker.tracking.mma import MmaConfig
from luxloop.tracker.tracking.output import report
from tests.support.one_track import DT, follow, start, straight


def arc(speed, yaw_rate, frames):
    """Return (K, 3) poses of a vehicle that turns."""
    yaw = yaw_rate * DT * np.arange(1, frames + 1)
    radius = speed / yaw_rate
    return np.stack([20.0 + radius * np.sin(yaw), 3.5 + radius * (1.0 - np.cos(yaw)), yaw], axis=1)


def mixed_traffic():
    """Return tracks that stand, drive straight on, turn, and use other filter banks."""
    banks = ("mma", "mma", "mma", "imm", "paper", "average")
    tracks = [start((20.0, 3.5, 0.0), mma=MmaConfig(method=method)) for method in banks]
    tracks.append(start((20.0, 3.5, 0.0), mma=MmaConfig(mode_time_s=1.0)))
    follow(tracks[0], straight((20.0, 3.5, 0.0), 0.0, 12))
    for track in tracks[1:]:
        follow(track, arc(9.0, 0.01, 12))
    follow(tracks[2], arc(9.0, 0.6, 12))
    return tracks


def assert_equal(one, other):
    """Compare all bits of two tracks."""
    found, expected = report([one]), report([other])
    names = ("mean", "covariance", "model_probability", "model_position_odom", "model_covariance_odom", "model_nis")
    for name in (*names, "status", "size", "corner_sign", "prediction_odom"):
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name), name)
    for name in ("mean", "covariance"):
        banks = [getattr(track.corner.bank.filters, name) for track in (one, other)]
        np.testing.assert_array_equal(*banks)
