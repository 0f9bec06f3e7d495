"""One track, fed with perfect or noisy observations of a known vehicle."""

import numpy as np
from support.seen import observe_boxes

from luxloop.tracker.tracking import orientation
from luxloop.tracker.tracking.confirmation import ConfirmationConfig
from luxloop.tracker.tracking.corner_error import CornerConfig
from luxloop.tracker.tracking.existence import ExistenceConfig
from luxloop.tracker.tracking.filters import FilterConfig, motion
from luxloop.tracker.tracking.hypotheses import HypothesisConfig, hypothesise
from luxloop.tracker.tracking.mma import MmaConfig
from luxloop.tracker.tracking.model_selection import BankSelection
from luxloop.tracker.tracking.orientation import OrientationConfig
from luxloop.tracker.tracking.output import report
from luxloop.tracker.tracking.track import Track
from luxloop.tracker.tracking.track_arrays import predictions
from luxloop.tracker.tracking.track_config import TrackConfig
from luxloop.tracker.tracking.track_observation import first_observation, track_observation
from luxloop.tracker.tracking.traffic_flow import TrafficFlow
from luxloop.tracker.tracking.vehicle_size import ExtentConfig

DT = 0.08
CAR = np.array([4.7, 1.8])
LIFE, MMA = ConfirmationConfig(), MmaConfig()
CONFIG = TrackConfig(
    FilterConfig(),
    ExtentConfig(hidden_length_m=0.0, hidden_width_m=0.0),
    OrientationConfig(),
    CornerConfig(),
    LIFE,
    ExistenceConfig(),
)
UNCUT = (False, False, False, False)


def flow_of(*poses, forward=0.0):
    """Return the flow of neighbours (x, y, heading), with ids from 1, beside an ego with heading `forward` [rad]."""
    table = np.array(poses, dtype=float).reshape(-1, 3)
    return TrafficFlow(np.arange(1, len(table) + 1), table[:, :2], table[:, 2], forward)


def start(pose, flow=None, size=CAR, mma=MMA, cut=UNCUT, time_offset=0.0):
    """A track of a vehicle; without a flow, the ego is parallel to it and there are no neighbours."""
    flow = flow_of(forward=pose[2]) if flow is None else flow
    seen = observe_boxes(pose, size, cut=cut, time_offset=time_offset)
    shape = orientation.shape_log_odds(seen.size[0], seen.whole[0])
    turns = orientation.likeliest_turns(shape, seen.center[0], float(seen.heading[0]), flow, least=0.0)
    first, corner = first_observation(seen, 0, turns, CAR)
    bank = BankSelection(CONFIG.filters, mma).new_bank(corner, first.covariance)
    return Track(0, corner, first, CONFIG, bank)


def follow(track, poses, rng=None, size=CAR, flow=None, cut=UNCUT):
    """Feed one observation per pose; return (K, 2) the reported centre after each."""
    centers = []
    for pose in poses:
        noise = np.zeros(3) if rng is None else rng.normal(0, [0.05, 0.05, 0.02])
        seen = observe_boxes(np.asarray(pose) + noise, size, cut=cut)
        track.predict(motion(DT, FilterConfig()))
        track.update(track_observation(hypothesise(predictions([track]), seen, HypothesisConfig()), seen, 0, 0))
        track.orient(flow_of() if flow is None else flow)
        track.settle()
        centers.append(report([track]).center_odom[0])
    return np.array(centers)


def straight(start_pose, speed, frames):
    """Return (K, 3) poses of a vehicle that drives straight on."""
    x, y, yaw = start_pose
    travelled = speed * DT * np.arange(1, frames + 1)
    return np.stack([x + np.cos(yaw) * travelled, y + np.sin(yaw) * travelled, np.full(frames, yaw)], axis=1)
