"""Stages with one fault each, to plant into the shipped tracker, and beneath its oracles."""

from dataclasses import replace

import numpy as np

from luxloop.tracker.detection.detector import Detector
from luxloop.tracker.detection.segmentation import SegmentationConfig, segment
from luxloop.tracker.geometry import fold
from luxloop.tracker.records import MODELS, Status
from luxloop.tracker.tracker import Tracker, track_config
from luxloop.tracker.tracking.association import HungarianAssociator, LikelihoodScore
from luxloop.tracker.tracking.model_selection import SelectedModel
from luxloop.tracker.tracking.track_management import DefaultTrackManagement

REACH_M = 4.0
BIAS_RAD = np.radians(5.0)
HITS = 14
LONGER_M = 1.5


class CoarseSegmentation(Detector):
    """Merges neighbouring vehicles into one segment."""

    def segment(self, scan, keep, _):
        return segment(scan.points_ego, keep, SegmentationConfig(radius_m=REACH_M))


class RemovingNothing(Detector):
    """Assigns every outlier to a line."""

    def link(self, points):
        linkage = super().link(points)
        return replace(linkage, line=np.where(points.segments.label >= 0, np.maximum(linkage.line, 0), -1))


class BiasedFit(Detector):
    """Turns every rectangle by the same angle."""

    def fit(self, points, linkage):
        candidates = super().fit(points, linkage)
        turned = candidates.heading + BIAS_RAD
        return replace(candidates, heading=np.where(np.isfinite(turned), fold(turned), np.nan))


class ScrambledAssociation(LikelihoodScore):
    """Inverts the gate for each box that is outside the gate of some track."""

    def __call__(self, tracks, predictions, hypotheses, observations):
        cost, in_gate = super().__call__(tracks, predictions, hypotheses, observations)
        wrong = ~in_gate
        return cost, np.where(wrong.any(axis=0), wrong, in_gate)


class AlwaysAccelerating(SelectedModel):
    """Selects constant acceleration for all vehicles."""

    def correct(self, tracks, rows, innovation, noise):
        used = super().correct(tracks, rows, innovation, noise)
        tracks.probability[rows] = np.eye(len(MODELS))[-1] * (1 - 3e-9) + 1e-9
        self.summarise(tracks, rows)
        return used


class SlowConfirmation(DefaultTrackManagement):
    """Confirms no track before it has been seen many times."""

    def settle(self, tracks, ego_pose):
        super().settle(tracks, ego_pose)
        tracks.status[(tracks.status == Status.CONFIRMED) & (tracks.hits < HITS)] = Status.TENTATIVE


class LongSizes(DefaultTrackManagement):
    """Makes every vehicle longer than it is."""

    def settle(self, tracks, ego_pose):
        super().settle(tracks, ego_pose)
        tracks.size[tracks.updated, 0] += LONGER_M  # every update estimates the size again


def plant(fault):
    """Return the factory of the shipped tracker with the fault."""
    if issubclass(fault, LikelihoodScore):
        return lambda config: Tracker(
            config, associator=HungarianAssociator(config.association, fault(config.association))
        )
    if issubclass(fault, SelectedModel):
        return lambda config: Tracker(config, model_selection=fault(config.mma))
    if issubclass(fault, DefaultTrackManagement):
        return lambda config: Tracker(config, track_management=fault(config.merging, track_config(config)))
    return lambda config: Tracker(config, fault(config))
