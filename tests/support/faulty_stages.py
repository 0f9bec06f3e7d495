"""Stages with one fault each, to plant into the shipped tracker, and beneath its oracles."""

from dataclasses import replace

import numpy as np

from scenarios.oracle.oracle_detector import OracleDetector
from scenarios.oracle.oracle_tracker import OracleTracker
from tracker.detection.detector import Detector
from tracker.detection.segmentation import SegmentationConfig, segment
from tracker.geometry import fold
from tracker.records import MODELS
from tracker.tracker import Tracker
from tracker.tracking.filter_bank import SelectedBank

REACH_M = 4.0
BIAS_RAD = np.radians(5.0)


class CoarseSegmentation(Detector):
    """Takes neighbours for one."""

    def segment(self, scan, keep, _):
        return segment(scan.points_ego, keep, SegmentationConfig(radius_m=REACH_M))


class RemovingNothing(Detector):
    """Takes every outlier for a point on a side."""

    def link(self, scan, segments):
        linkage = super().link(scan, segments)
        return replace(linkage, line=np.where(segments.label >= 0, np.maximum(linkage.line, 0), -1))


class BiasedFit(Detector):
    """Turns every rectangle by the same angle."""

    def fit(self, scan, segments, linkage):
        candidates = super().fit(scan, segments, linkage)
        turned = candidates.heading + BIAS_RAD
        return replace(candidates, heading=np.where(np.isfinite(turned), fold(turned), np.nan))


class ScrambledAssociation(Tracker):
    """Gives boxes to tracks only where the gate forbids it, if there is such a track."""

    def _score(self, predictions, pairing, seen):
        cost, in_gate = super()._score(predictions, pairing, seen)
        wrong = ~in_gate
        return cost, np.where(wrong.any(axis=0), wrong, in_gate)


class ObstinateBank(SelectedBank):
    """Holds that its vehicle accelerates."""

    def observe(self, residual, noise):
        raised = super().observe(residual, noise)
        self.probability = np.eye(len(MODELS))[-1] * (1 - 3e-9) + 1e-9
        return raised


class AlwaysAccelerating(Tracker):
    """Selects one model for all vehicles."""

    def _start(self, seen, track_id, forward):
        super()._start(seen, track_id, forward)
        for track in self._tracks:
            if type(track.bank) is SelectedBank:
                track.bank = ObstinateBank(track.bank.filters, self.config.mma)


def plant(fault):
    """The shipped tracker with the fault, and its oracles, as `blame.find_out` takes them."""
    if issubclass(fault, Detector):

        class Fitting(OracleDetector, fault):
            """Truth over the fault."""

        return (
            lambda config: Tracker(config, fault(config)),
            lambda stages: lambda config: OracleTracker(config, stages, Fitting),
        )

    class Tracking(OracleTracker, fault):
        """Truth over the fault."""

    return fault, lambda stages: lambda config: Tracking(config, stages)
