"""Memory of hidden vehicles: termination of coasting tracks whose predicted places are seen to be free."""

from collections.abc import Sequence

import numpy as np

from luxloop.tracker.arrays import Floats
from luxloop.tracker.records import Status
from luxloop.tracker.scan import Scan
from luxloop.tracker.seen_through import seen_through, turned_returns
from luxloop.tracker.tracking.existence import FREE_MARGIN_M, ExistenceConfig, existence
from luxloop.tracker.tracking.kernels import places as kernel
from luxloop.tracker.tracking.track import Track
from luxloop.tracker.tracking.track_arrays import boxes


def terminate_lost(tracks: Sequence[Track], scan: Scan, config: ExistenceConfig) -> None:
    """Terminate the coasting tracks that probably do not exist any more, after the updates by a scan."""
    coasting = [track for track in tracks if track.status is Status.COASTING and not track.seen]
    if not coasting:
        return
    covariance = np.array([track.covariance for track in coasting])
    places = predicted_places(coasting, covariance) - scan.ego_pose_odom[:2]
    returns = turned_returns(scan.points_ego, scan.ego_pose_odom[2])
    free = seen_through(places.reshape(-1, 2), returns, config.unit_offset_m, FREE_MARGIN_M)
    share = 1.0 - free.reshape(places.shape[:-1]).any(axis=2).mean(axis=1)
    vague = covariance[:, 0, 0] + covariance[:, 1, 1] > 2.0 * config.std_max_m**2
    for track, hidden, lost in zip(coasting, share.tolist(), vague.tolist(), strict=True):
        if lost or existence(track.unseen_s, hidden, config) < config.existence_min:
            track.status = Status.DEAD


def predicted_places(tracks: Sequence[Track], covariance: Floats) -> Floats:
    """(T, K, A, 2) places along each of the T vehicles at K equally likely positions, odometry frame [m].

    Their positions have covariances (T, 2, 2) [m^2].
    """
    center, heading, size = boxes(tracks)
    return np.asarray(kernel.predicted_places(center, heading, size[:, 0].copy(), covariance))
