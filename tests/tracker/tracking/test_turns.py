"""Heading of turning cars, seen with near-perfect points at 12.5 Hz."""

import numpy as np
import pytest
from support.driven_cars import confirmed, driven, track
from support.few import few

DT = 0.08
STRAIGHT, RAMP, TURN = 20, 6, 60
"""Frames of the straight, of the change of yaw rate (half a second), and of the turn."""


def turn(rate_dps, speed_mps, side=1):
    """(K, 3) poses of a car that drives straight and then turns by a constant rate."""
    ramp = np.linspace(0.0, 1.0, RAMP + 1)[1:]
    rate = np.deg2rad(rate_dps) * side * np.concatenate([np.zeros(STRAIGHT), ramp, np.ones(TURN)])
    start = (24.0, -side * 6.0 + 2.0, np.pi)
    return driven(start, speed_mps, rate, DT)


def lags(poses, record):
    """(K,) heading error of the only confirmed track, and the set of ids, from the tenth frame on."""
    error, ids = [], set()
    for pose, tracks in zip(poses[10:], record[10:], strict=True):
        (sure,) = confirmed(tracks)
        ids.add(int(tracks.id[sure]))
        error.append(np.angle(np.exp(1j * (tracks.mean[sure, 6] - pose[2])), deg=True))
    return np.abs(error), ids


@pytest.mark.parametrize("side", few([1, -1], 1))
@pytest.mark.parametrize(
    ("rate_dps", "speed_mps", "limit_deg"),
    few([(30, 8, 3.0), (40, 8, 4.0), (60, 8, 5.0), (60, 5, 5.0), (90, 5, 8.0)], 30, 90),
)
def test_the_heading_follows_a_turn_with_one_id(rate_dps, speed_mps, limit_deg, side):
    poses = turn(rate_dps, speed_mps, side)
    lag, ids = lags(poses, track(poses[:, None], DT))
    assert len(ids) == 1
    assert lag.max() <= limit_deg
