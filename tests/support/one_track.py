"""A track, fed with perfect or noisy observations of a known vehicle."""

import numpy as np
from support.seen import observe_boxes

from luxloop.tracker.merging import MergeConfig
from luxloop.tracker.records import Status
from luxloop.tracker.tracking.confirmation import ConfirmationConfig
from luxloop.tracker.tracking.corner import CornerConfig
from luxloop.tracker.tracking.correction import correct
from luxloop.tracker.tracking.existence import ExistenceConfig
from luxloop.tracker.tracking.filters import FilterConfig, motion
from luxloop.tracker.tracking.hypotheses import HypothesisConfig, Predictions, hypothesise
from luxloop.tracker.tracking.mma import MmaConfig
from luxloop.tracker.tracking.model_selection import model_selection
from luxloop.tracker.tracking.output import report
from luxloop.tracker.tracking.prediction import predict
from luxloop.tracker.tracking.track_config import TrackConfig
from luxloop.tracker.tracking.track_management import DefaultTrackManagement
from luxloop.tracker.tracking.track_observation import assigned
from luxloop.tracker.tracking.track_table import empty
from luxloop.tracker.tracking.traffic_flow import TrafficFlow

DT = 0.08
CAR = np.array([4.7, 1.8])
LIFE, MMA = ConfirmationConfig(), MmaConfig()
CONFIG = TrackConfig(FilterConfig(), CornerConfig(), LIFE, ExistenceConfig())
EGO = np.zeros(3)
UNCUT = (False, False, False, False)


class OneTrack:
    """A table of one track, with the stages that change it."""

    def __init__(self, seen, flow, mma=MMA):
        self.selection, self._management = model_selection(mma), DefaultTrackManagement(MergeConfig(), CONFIG)
        none, first = empty(CONFIG.filters.models), np.ones(1, dtype=np.bool_)
        self.table = self._management.start(none, first, seen, np.zeros(1, dtype=np.int64), flow, self.selection)

    def predict(self):
        """Move on by one scan."""
        predict(self.table, motion(DT, CONFIG.filters), self.selection, CONFIG)

    def correct(self, seen):
        """Update the track by the only box."""
        hypotheses = hypothesise(Predictions.of(self.table), seen, HypothesisConfig())
        correct(self.table, assigned(hypotheses, seen, [(0, 0)]), self.selection, CONFIG, DT)

    def manage(self, flow):
        """Turn the vehicle to its likeliest direction, and update its status."""
        self._management.orient(self.table, flow)
        self.settle(flow.ego_pose)

    def settle(self, ego_pose=EGO):
        """Update the status beside an ego at x, y [m] and heading [rad] (3,)."""
        self._management.settle(self.table, ego_pose)

    @property
    def record(self):
        return report(self.table, self.selection)

    @property
    def status(self):
        return Status(self.table.status.item(0))

    @property
    def heading(self):
        return self.table.yaw.item(0, 0)

    @property
    def position(self):
        return self.table.estimate[0, :2]


def flow_of(*poses, forward=0.0):
    """Return the flow of neighbours (x, y, heading), with ids from 1, beside an ego with heading `forward` [rad]."""
    table = np.array(poses, dtype=float).reshape(-1, 3)
    ids, known = np.arange(1, len(table) + 1), np.ones(len(table), dtype=bool)
    return TrafficFlow(ids, table[:, :2].copy(), table[:, 2].copy(), known, np.array([0.0, 0.0, forward]))


def start(pose, flow=None, size=CAR, mma=MMA, cut=UNCUT, time_offset=0.0):
    """A track of a vehicle; without a flow, the ego is parallel to it and there are no neighbours."""
    flow = flow_of(forward=pose[2]) if flow is None else flow
    return OneTrack(observe_boxes(pose, size, cut=cut, time_offset=time_offset), flow, mma)


def follow(track, poses, rng=None, size=CAR, flow=None, cut=UNCUT):
    """Feed one observation per pose; return (K, 2) the reported centre after each."""
    centers = []
    for pose in poses:
        noise = np.zeros(3) if rng is None else rng.normal(0, [0.05, 0.05, 0.02])
        track.predict()
        track.correct(observe_boxes(np.asarray(pose) + noise, size, cut=cut))
        track.manage(flow_of() if flow is None else flow)
        centers.append(track.record.center_odom[0])
    return np.array(centers)


def joined(tracks):
    """Return the table of several tracks."""
    return tracks[0].table.joined([track.table for track in tracks[1:]])


def straight(start_pose, speed, frames):
    """Return (K, 3) poses of a vehicle that drives straight on."""
    x, y, yaw = start_pose
    travelled = speed * DT * np.arange(1, frames + 1)
    return np.stack([x + np.cos(yaw) * travelled, y + np.sin(yaw) * travelled, np.full(frames, yaw)], axis=1)
