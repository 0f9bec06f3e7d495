"""The worst frames of a run, kept with their points for the pictures of a report.

A fixed number of frames is kept per kind of error (`SNAPSHOT_KINDS`); memory does not grow with the length of the run.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pandas as pd

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading.frame_tables import SNAPSHOT_KINDS, SNAPSHOT_POINTS, SNAPSHOTS, TableBuilder
from luxloop.scenarios.grading.frame_truth import FrameTruth
from luxloop.scenarios.grading.matching import NO_TRACK, TrackVerdict
from luxloop.scenarios.grading.track_matches import TrackMatches
from luxloop.sensor_model.truth import NO_ACTOR
from luxloop.sim.world import Mode
from luxloop.tracker.records import Tracks

PER_KIND = 2
"""Frames kept of each kind."""
APART_S = 2.0
"""Least time between two frames of a kind [s], so that they show different situations."""
CONFIRMATION_S = 1.0
"""Time after which a graded vehicle without a track counts as an error [s]: track confirmation takes time."""
LISTED = 3
"""Vehicles and tracks that the description of a frame names."""


@dataclass(frozen=True, slots=True, eq=False)
class Snapshot:
    """A frame with one error."""

    kind: str
    """An element of `SNAPSHOT_KINDS`."""
    badness: float
    """Size of the error, a count or degrees; larger is worse among frames of the same kind."""
    what: str
    """Description of the error."""
    place_ego: Floats
    """(2,) position of the error in the ego frame [m]."""
    frame_truth: FrameTruth


class Snapshots:
    """Keeps the worst frames of each kind."""

    def __init__(self) -> None:
        self._kept: dict[str, list[Snapshot]] = {kind: [] for kind in SNAPSHOT_KINDS}
        self._graded_since: dict[int, float] = {}
        self._follower: dict[int, int] = {}

    def add(
        self, frame_truth: FrameTruth, matches: TrackMatches, tracks: Tracks, box_actor: Ints, box_error: Floats
    ) -> None:
        """Keep one frame if it is among the worst of a kind.

        Parameters
        ----------
        box_actor, box_error
            `FrameGrade.box_actor` and `FrameGrade.box_heading_error`.
        """
        for found in (
            *self._detection(frame_truth, matches, tracks),
            *self._identity(frame_truth, matches, tracks),
            *_track_heading(frame_truth, matches, tracks),
            *_fit_heading(frame_truth, box_actor, box_error),
        ):
            _keep(self._kept[found.kind], found)

    def tables(self) -> dict[str, pd.DataFrame]:
        """Return the tables `snapshots` and `snapshot_points`; the worst of each kind first."""
        snapshots, points = TableBuilder(SNAPSHOTS), TableBuilder(SNAPSHOT_POINTS)
        kept = [snapshot for kind in SNAPSHOT_KINDS for snapshot in self._kept[kind]]
        for snapshot in kept:
            snapshots.add(snapshot.frame_truth.frame, _row(snapshot))
        for frame_truth in {snapshot.frame_truth.frame.index: snapshot.frame_truth for snapshot in kept}.values():
            points.add(frame_truth.frame, _point_rows(frame_truth))
        return {"snapshots": snapshots.build(), "snapshot_points": points.build()}

    def _detection(self, frame_truth: FrameTruth, matches: TrackMatches, tracks: Tracks) -> Iterator[Snapshot]:
        """Yield a snapshot of graded vehicles without a track and false tracks, if there are any."""
        time, graded = frame_truth.frame.time, frame_truth.actors.id[frame_truth.graded].tolist()
        self._graded_since = {actor: self._graded_since.get(actor, time) for actor in graded}
        waiting = [actor for actor, since in self._graded_since.items() if time - since >= CONFIRMATION_S]
        missed = np.isin(frame_truth.actors.id, waiting)
        missed[matches.actor_row[matches.actor_row >= 0]] = False
        false = matches.verdict == TrackVerdict.FALSE
        places = np.vstack([frame_truth.boxes_ego[missed, :2], matches.boxes_ego[false, :2]])
        if len(places):
            what = listed(
                [*_misses(frame_truth, matches, missed), *(f"false track {track}" for track in tracks.id[false])]
            )
            nearest = places[np.hypot(*places.T).argmin()]
            yield Snapshot("detection", float(len(places)), what, nearest, frame_truth)

    def _identity(self, frame_truth: FrameTruth, matches: TrackMatches, tracks: Tracks) -> Iterator[Snapshot]:
        """Yield a snapshot of graded vehicles that changed their track, if there are any."""
        follower = matches.track_of_actor(frame_truth, tracks)
        changed = []
        for row in np.flatnonzero(frame_truth.graded & (follower != NO_TRACK)).tolist():
            actor, track = int(frame_truth.actors.id[row]), int(follower[row])
            name = frame_truth.actors.name[row]
            before = self._follower.get(actor, track)
            if before != track:
                changed.append((row, f"vehicle {name} goes from track {before} to track {track}"))
            self._follower[actor] = track
        if changed:
            rows, words = zip(*changed, strict=True)
            yield Snapshot(
                "identity", float(len(rows)), "; ".join(words), frame_truth.boxes_ego[rows[0], :2], frame_truth
            )


def _track_heading(frame_truth: FrameTruth, matches: TrackMatches, tracks: Tracks) -> Iterator[Snapshot]:
    """Yield a snapshot of the largest heading error of a track on a moving graded vehicle."""
    judged = np.flatnonzero(matches.verdict == TrackVerdict.GRADED)
    row = matches.actor_row[judged]
    # The outline of a standing vehicle does not show its front.
    moving = frame_truth.actors.mode[row] != Mode.STATIONARY
    error = np.degrees(matches.heading_error[judged][moving])
    if len(error):
        worst = np.abs(error).argmax()
        actor, track = row[moving][worst], tracks.id[judged][moving][worst]
        name = frame_truth.actors.name[actor]
        what = f"track {track} on vehicle {name} is {error[worst]:+.1f}° off in its track heading"
        place = frame_truth.boxes_ego[actor, :2]
        yield Snapshot("track_heading", abs(float(error[worst])), what, place, frame_truth)


def _fit_heading(frame_truth: FrameTruth, box_actor: Ints, box_error: Floats) -> Iterator[Snapshot]:
    """Yield a snapshot of the largest heading error of a fitted box, modulo a quarter turn."""
    owned = np.flatnonzero(box_actor != NO_ACTOR)
    if len(owned):
        worst = owned[np.abs(box_error[owned]).argmax()]
        error = np.degrees(box_error[worst])
        actor = int(np.flatnonzero(frame_truth.actors.id == box_actor[worst])[0])
        place, name = frame_truth.boxes_ego[actor, :2], frame_truth.actors.name[actor]
        what = f"the rectangle fitted to vehicle {name} is {error:+.1f}° off in its fit heading"
        yield Snapshot("fit_heading", abs(float(error)), what, place, frame_truth)


def listed(parts: list[str]) -> str:
    """Return the first `LISTED` parts of a description, and the number of the others."""
    more = [f"{len(parts) - LISTED} more"] if len(parts) > LISTED else []
    return "; ".join([*parts[:LISTED], *more])


def _misses(frame_truth: FrameTruth, matches: TrackMatches, missed: Bools) -> Iterator[str]:
    """Yield each vehicle of a mask (A,), and the largest overlap of a track with it, if any."""
    for row in np.flatnonzero(missed).tolist():
        largest = matches.overlap[row].max(initial=0.0)
        near = f", the nearest overlaps it by {largest:.2f}" if largest > 0.0 else ""
        yield f"no track on vehicle {frame_truth.actors.name[row]}{near}"


def _keep(kept: list[Snapshot], new: Snapshot) -> None:
    """Insert a snapshot into `kept` (worst first) unless a worse one is near in time."""
    time = new.frame_truth.frame.time
    near = [old for old in kept if abs(old.frame_truth.frame.time - time) < APART_S]
    if not any(old.badness >= new.badness for old in near):
        rest = [old for old in kept if old not in near]
        kept[:] = sorted([*rest, new], key=lambda snapshot: -snapshot.badness)[:PER_KIND]


def _row(snapshot: Snapshot) -> dict[str, npt.NDArray[np.generic]]:
    ego = snapshot.frame_truth.frame.ego
    values = (SNAPSHOT_KINDS.index(snapshot.kind), snapshot.badness, snapshot.what, *snapshot.place_ego)
    columns = (*values, *ego.pose_world, *ego.size[:2])
    return {name: np.array([value]) for name, value in zip(SNAPSHOTS, columns, strict=True)}


def _point_rows(frame_truth: FrameTruth) -> dict[str, npt.NDArray[np.generic]]:
    x, y, _ = frame_truth.scan.points_ego.T
    return {"x_ego_m": x, "y_ego_m": y, "actor_id": frame_truth.truth.actor_id, "cause": frame_truth.truth.cause}
