"""Runs of the shipped tracker, kept frame by frame, to be graded again with modified tracks."""

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import cache, cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from luxloop.scenarios.compare.digest import RunDigest, digest
from luxloop.scenarios.files import shipped
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.grading import frame_tables
from luxloop.scenarios.grading.frame_tables import TableBuilder
from luxloop.scenarios.grading.frame_truth import FrameTruth
from luxloop.scenarios.grading.grader import Grader
from luxloop.scenarios.grading.matching import TrackMatcher
from luxloop.scenarios.grading.plane_geometry import turned
from luxloop.scenarios.grading.track_matches import TrackMatches
from luxloop.scenarios.grading.truth_events.event_log import EventLog
from luxloop.scenarios.result import Result
from luxloop.scenarios.run import loop
from luxloop.sensor_model.rig.rig import load_rig
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.world import WorldFrame
from luxloop.tracker.records import StepTrace, Tracks
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import Tracker

STREET = """\
description = "A street with moving and stationary vehicles."
duration_s = 5.0

[traffic]
kind = "scripted"
ego = { motion = [{ kind = "straight", speed_mps = 10.0 }] }
actor = [
    { x_m = 12.0, y_m = 3.5, motion = [{ kind = "straight", speed_mps = 11.0 }] },
    { x_m = -12.0, y_m = -3.5, motion = [{ kind = "straight", speed_mps = 12.0 }] },
    { x_m = 2.0, y_m = 3.8, kind = "truck", motion = [{ kind = "straight", speed_mps = 10.0 }] },
    { x_m = -20.0, y_m = 7.3, motion = [{ kind = "straight", speed_mps = 18.0 }] },
    { x_m = 45.0, y_m = 8.0, yaw_deg = 180.0, motion = [{ kind = "straight", speed_mps = 9.0 }] },
    { x_m = 18.0, y_m = -6.0, yaw_deg = 4.0 },
    { x_m = 30.0, y_m = -6.0, yaw_deg = -3.0 },
    { x_m = 26.0, y_m = 0.2, motion = [{ kind = "straight", speed_mps = 10.0 }] },
]
"""


class Frame(NamedTuple):
    """Input of the grader for one frame."""

    frame: WorldFrame
    scan: Scan
    truth: ScanTruth
    tracks: Tracks
    trace: StepTrace


@dataclass(frozen=True, eq=False)
class Recorded:
    """A run with its frames."""

    scenario: Scenario
    result: Result
    frames: list[Frame]
    instants: list[FrameTruth]

    @classmethod
    def of(cls, scenario: Scenario) -> "Recorded":
        """Run a scenario and keep its frames."""
        frames, outputs = [], []

        class RecordingTracker(Tracker):
            def step(self, scan):
                outputs.append(super().step(scan))
                return outputs[-1]

        def keep(frame, scan, truth, _grade):
            frames.append(Frame(frame, scan, truth, *outputs[-1]))

        result = loop.run(scenario, RecordingTracker, export=keep)
        result = replace(result, config={key: of for key, of in result.config.items() if key != "in_process"})
        grading, events = scenario.grading, EventLog(*_limits(scenario))
        instants = [FrameTruth.of(*frame[:3], grading, events.add(frame.frame, frame.truth)) for frame in frames]
        return cls(scenario, result, frames, instants)

    @cached_property
    def followed(self) -> list[tuple[TrackMatches, dict[str, Any]]]:
        """Matches of the tracks in every frame, and their rows of the table."""
        matcher = TrackMatcher(self.scenario.grading)
        followed = [
            TrackMatches.of(now, frame.tracks, matcher) for frame, now in zip(self.frames, self.instants, strict=True)
        ]
        return [
            (f, f.rows(now, frame.tracks)) for f, now, frame in zip(followed, self.instants, self.frames, strict=True)
        ]

    def with_tracks(self, change: Callable[[Frame, TrackMatches, dict[str, Any]], Tracks], name: str) -> RunDigest:
        """Grade tracks that `change` derives from a frame, the matches of the tracker's tracks and their table rows.

        Metrics of earlier stages are copied; `name` replaces the trace hash.
        """
        matcher = TrackMatcher(self.scenario.grading)
        tracks, overlaps, track_id = TableBuilder(frame_tables.TRACKS), TableBuilder(frame_tables.OVERLAPS), []
        for frame, now, before in zip(self.frames, self.instants, self.followed, strict=True):
            changed = change(frame, *before)
            following = TrackMatches.of(now, changed, matcher)
            tracks.add(frame.frame, following.rows(now, changed))
            overlaps.add(frame.frame, following.overlap_rows(now, changed))
            track_id.append(following.track_of_actor(now, changed))
        graded = {**self.result.tables, "tracks": tracks.build(), "overlaps": overlaps.build()}
        graded["truth"] = graded["truth"].assign(track_id=np.concatenate(track_id))
        return digest(replace(self.result, trace_hash=name, tables=graded))

    def with_device(self, device: Any, name: str) -> RunDigest:
        """Run another device on the recorded scans and grade its output."""
        grader = Grader(self.scenario.grading, delivered_m=_limits(self.scenario)[2])
        for frame in self.frames:
            grader.add(*frame[:3], *device.step(frame.scan))
        metrics, graded = grader.finish()
        return digest(replace(self.result, trace_hash=name, metrics=self.result.metrics | metrics, tables=graded))


def _limits(scenario: Scenario) -> tuple[float, float, float]:
    """Return the arguments of `EventLog`."""
    rig = load_rig(str(scenario.rig), scenario.folder)
    return scenario.grading.hidden_fraction_max, scenario.grading.range_max_m, rig.range_max_m


@cache
def runs() -> list[Recorded]:
    """Return three runs of a street and one of a SUMO crossing: about 50 vehicles."""
    with TemporaryDirectory() as folder:
        street = Path(folder) / "street.toml"
        street.write_text(STREET, encoding="utf-8")
        streets = [Recorded.of(Scenario.load(street, {"seed": seed})) for seed in (1, 2, 3)]
    crossing = Scenario.load(shipped.find("sumo-crossing"), {"duration_s": 6.0})
    return [*streets, Recorded.of(crossing)]


@cache
def base() -> tuple[RunDigest, ...]:
    """Return the digests of the unmodified runs."""
    return tuple(digest(run.result) for run in runs())


class Shuffled(Tracker):
    """The shipped tracker with the points of every scan in random order."""

    def __init__(self, seed: int) -> None:
        super().__init__()
        self._rng = np.random.default_rng(seed)

    def step(self, scan: Scan) -> tuple[Tracks, StepTrace]:
        order = self._rng.permutation(len(scan.points_ego))
        columns = {f.name: getattr(scan, f.name) for f in fields(Scan)}
        per_point = {name: column[order] for name, column in columns.items() if np.shape(column)[:1] == order.shape}
        tracks, trace = super().step(replace(scan, **per_point))
        back = np.argsort(order)
        segments = replace(trace.segments, label=trace.segments.label[back])
        return tracks, replace(trace, segments=segments, linkage=replace(trace.linkage, line=trace.linkage.line[back]))


def jitter(seed: int, sigma_m: float) -> Callable[..., Tracks]:
    """Shift every track by a zero-mean normal error."""
    rng = np.random.default_rng(seed)
    return lambda frame, *_: _shifted(frame.tracks, rng.normal(0.0, sigma_m, (len(frame.tracks), 2)))


def withhold(seed: int, share: float) -> Callable[..., Tracks]:
    """Remove a random share of the tracks."""
    rng = np.random.default_rng(seed)
    return lambda frame, *_: _select(frame.tracks, rng.random(len(frame.tracks)) >= share)


def worse_position(share: float) -> Callable[..., Tracks]:
    """Increase the error of every corner by a share."""

    def change(frame: Frame, _following: TrackMatches, rows: dict[str, Any]) -> Tracks:
        error_ego = np.nan_to_num(np.column_stack([rows["mma_x_error_m"], rows["mma_y_error_m"]]))
        return _shifted(frame.tracks, share * turned(error_ego, np.full(len(error_ego), frame.scan.ego_pose_odom[2])))

    return change


def worse_heading(share: float) -> Callable[..., Tracks]:
    """Increase every heading error by a share."""

    def change(frame: Frame, following: TrackMatches, _rows: dict[str, Any]) -> Tracks:
        mean = frame.tracks.mean.copy()
        mean[:, 6] += share * np.nan_to_num(following.heading_error)
        return replace(frame.tracks, mean=mean)

    return change


def _select(tracks: Tracks, kept: Any) -> Tracks:
    columns = {field.name: getattr(tracks, field.name) for field in fields(Tracks)}
    rows = {name: column[kept] for name, column in columns.items() if name != "models" and column is not None}
    return replace(tracks, **rows)


def _shifted(tracks: Tracks, offset_odom: Any) -> Tracks:
    mean = tracks.mean.copy()
    mean[:, :2] += offset_odom
    return replace(tracks, mean=mean, model_position_odom=tracks.model_position_odom + offset_odom[:, None])
