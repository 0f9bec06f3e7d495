"""Shipped tracker with one fault planted in its output, each for one family of metrics to detect."""

import math
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np
from support.shared_scans import PlayedTracker

from luxloop.tracker.geometry import QUARTER
from luxloop.tracker.records import METHODS, MODELS

CA = MODELS.index("ca")


@dataclass
class Sound:
    """Shipped tracker without a fault. All trackers with planted faults share its outputs."""

    outputs: ClassVar[dict[bytes, bytes]] = {}
    config: object
    tracker: PlayedTracker = field(init=False)

    def __post_init__(self):
        self.tracker = PlayedTracker(self.config, Sound.outputs)

    def step(self, scan):
        tracks, trace = self.tracker.step(scan)
        return self.tracks(tracks), self.trace(trace)

    def tracks(self, tracks):
        return tracks

    def trace(self, trace):
        return trace


class BiasedFits(Sound):
    """Rotates every rectangle about its centre."""

    bias_deg: ClassVar = 3.0

    def trace(self, trace):
        turned = trace.candidates.heading + math.radians(self.bias_deg)
        return replace(trace, candidates=replace(trace.candidates, heading=turned))


class WorstFits(Sound):
    """Selects the rectangle of the heading farthest from the best one, instead of the best."""

    def trace(self, trace):
        candidates = trace.candidates
        heading = candidates.heading[:, : len(METHODS)]
        best = np.take_along_axis(candidates.heading, candidates.best[:, None], axis=1)
        worst = np.abs((heading - best + QUARTER / 2) % QUARTER - QUARTER / 2).argmax(axis=1)
        return replace(trace, candidates=replace(candidates, best=worst))


class SplitSegments(Sound):
    """Moves two of five points of every segment to another segment; rectangles do not change."""

    def trace(self, trace):
        label, count = trace.segments.label.copy(), trace.segments.count
        for segment in range(count):
            member = np.flatnonzero(label == segment)
            label[member[np.arange(len(member)) % 5 >= 3]] = count + segment
        twice = np.tile(np.arange(count), 2)
        candidates = replace_all(trace.candidates, lambda values: values[twice])
        segments = replace(trace.segments, label=label, count=2 * count)
        linkage = replace(trace.linkage, heading=trace.linkage.heading[twice])
        return replace(trace, segments=segments, linkage=linkage, candidates=candidates)


class MergedSegments(Sound):
    """Merges all segments into one."""

    def trace(self, trace):
        label = np.minimum(trace.segments.label, 0)
        count = min(trace.segments.count, 1)
        boxes = trace.boxes.subset(np.flatnonzero(trace.boxes.segment < count))
        return replace(
            trace,
            segments=replace(trace.segments, label=label, count=count),
            linkage=replace(trace.linkage, heading=trace.linkage.heading[:count]),
            candidates=replace_all(trace.candidates, lambda values: values[:count]),
            boxes=boxes,
            track_id=trace.track_id[: len(boxes)],
        )


class NoSegments(Sound):
    """Removes all segments."""

    def trace(self, trace):
        return replace(
            trace,
            segments=replace(trace.segments, label=np.full_like(trace.segments.label, -1), count=0),
            linkage=replace(trace.linkage, heading=trace.linkage.heading[:0]),
            candidates=replace_all(trace.candidates, lambda values: values[:0]),
            boxes=trace.boxes.subset(np.empty(0, np.int64)),
            track_id=trace.track_id[:0],
        )


class KeepingLinkage(Sound):
    """Marks no point as an outlier."""

    def trace(self, trace):
        return replace(trace, linkage=replace(trace.linkage, line=np.maximum(trace.linkage.line, 0)))


class RemovingLinkage(Sound):
    """Marks every point as an outlier."""

    def trace(self, trace):
        return replace(trace, linkage=replace(trace.linkage, line=np.full_like(trace.linkage.line, -1)))


class AlwaysAccelerating(Sound):
    """Selects the model of constant acceleration, with its position, for every track."""

    def tracks(self, tracks):
        mean = tracks.mean.copy()
        mean[:, :2] = tracks.model_position_odom[:, CA]
        sure = np.eye(len(MODELS))[np.full(len(tracks), CA)]
        return replace(tracks, mean=mean, model=np.full(len(tracks), CA), model_probability=sure)


class Overconfident(Sound):
    """Divides covariances by four."""

    factor: ClassVar = 4.0

    def tracks(self, tracks):
        return replace(
            tracks,
            covariance=tracks.covariance / self.factor,
            model_covariance_odom=tracks.model_covariance_odom / self.factor,
        )


def replace_all(record, change):
    """Apply a change to every field of a record."""
    return replace(record, **{name: change(getattr(record, name)) for name in record.__slots__})
