"""The worst few frames of a run, kept with their points for the pictures of a report.

Frames are kept by what is wrong in them, `SNAPSHOT_KINDS`; memory and time do not grow with the length of the run.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pandas as pd

from scenarios.arrays import Floats, Ints
from scenarios.grading.frame_tables import SNAPSHOT_KINDS, SNAPSHOT_POINTS, SNAPSHOTS, TableBuilder
from scenarios.grading.frame_truth import Instant
from scenarios.grading.matching import NO_TRACK, TrackVerdict
from scenarios.grading.track_matches import Following
from sensor_model.truth import NO_ACTOR
from sim.world import Mode
from tracker.records import Tracks

PER_KIND = 2
"""Frames kept of each kind."""
APART_S = 2.0
"""[s] between two of a kind, or they would show the same moment."""
PATIENCE_S = 1.0
"""[s] that a vehicle may be graded without a track before the picture is worth it: tracks take time to confirm."""


@dataclass(frozen=True, slots=True, eq=False)
class Snapshot:
    """A frame and one thing that is wrong in it."""

    kind: str
    badness: float
    """The larger the worse, of frames of the same kind: a count, or degrees."""
    what: str
    """In words."""
    place_ego: Floats
    """(2,) where [m]."""
    now: Instant


class Snapshots:
    """Is shown every frame and keeps the worst."""

    def __init__(self) -> None:
        self._kept: dict[str, list[Snapshot]] = {kind: [] for kind in SNAPSHOT_KINDS}
        self._graded_since: dict[int, float] = {}
        self._follower: dict[int, int] = {}

    def add(self, now: Instant, following: Following, tracks: Tracks, box_actor: Ints, box_error: Floats) -> None:
        """Look at one frame.

        Parameters
        ----------
        box_actor, box_error
            As in `FrameGrade`.
        """
        for found in (
            *self._detection(now, following),
            *self._identity(now, following, tracks),
            *_track_heading(now, following, tracks),
            *_fit_heading(now, box_actor, box_error),
        ):
            _keep(self._kept[found.kind], found)

    def tables(self) -> dict[str, pd.DataFrame]:
        """Return the tables `snapshots` and `snapshot_points`; the worst of each kind first."""
        snapshots, points = TableBuilder(SNAPSHOTS), TableBuilder(SNAPSHOT_POINTS)
        kept = [snapshot for kind in SNAPSHOT_KINDS for snapshot in self._kept[kind]]
        for snapshot in kept:
            snapshots.add(snapshot.now.frame, _row(snapshot))
        for now in {snapshot.now.frame.index: snapshot.now for snapshot in kept}.values():
            points.add(now.frame, _point_rows(now))
        return {"snapshots": snapshots.build(), "snapshot_points": points.build()}

    def _detection(self, now: Instant, following: Following) -> Iterator[Snapshot]:
        """Graded vehicles without a track, and tracks on nothing."""
        time, graded = now.frame.time, now.actors.id[now.graded].tolist()
        self._graded_since = {actor: self._graded_since.get(actor, time) for actor in graded}
        waiting = [actor for actor, since in self._graded_since.items() if time - since >= PATIENCE_S]
        alone = np.isin(now.actors.id, waiting)
        alone[following.actor_row[following.actor_row >= 0]] = False
        false = following.verdict == TrackVerdict.FALSE
        places = np.vstack([now.boxes_ego[alone, :2], following.boxes_ego[false, :2]])
        if len(places):
            what = f"{alone.sum()} graded vehicles without a track, {false.sum()} tracks on nothing"
            nearest = places[np.hypot(*places.T).argmin()]
            yield Snapshot("detection", float(len(places)), what, nearest, now)

    def _identity(self, now: Instant, following: Following, tracks: Tracks) -> Iterator[Snapshot]:
        """Graded vehicles that another track follows than the last that did."""
        follower = following.track_of_actor(now, tracks)
        changed = []
        for row in np.flatnonzero(now.graded & (follower != NO_TRACK)).tolist():
            actor, track = int(now.actors.id[row]), int(follower[row])
            before = self._follower.get(actor, track)
            if before != track:
                changed.append((row, f"vehicle {actor} goes from track {before} to track {track}"))
            self._follower[actor] = track
        if changed:
            rows, words = zip(*changed, strict=True)
            yield Snapshot("identity", float(len(rows)), "; ".join(words), now.boxes_ego[rows[0], :2], now)


def _track_heading(now: Instant, following: Following, tracks: Tracks) -> Iterator[Snapshot]:
    """The track on a moving graded vehicle whose heading is most off."""
    judged = np.flatnonzero(following.verdict == TrackVerdict.GRADED)
    row = following.actor_row[judged]
    moving = now.actors.mode[row] != Mode.STATIONARY  # the front of a standing one cannot be told
    error = np.degrees(following.heading_error[judged][moving])
    if len(error):
        worst = np.abs(error).argmax()
        actor = row[moving][worst]
        what = f"track {tracks.id[judged][moving][worst]} on vehicle {now.actors.id[actor]} points {error[worst]:+.1f}°"
        yield Snapshot("track_heading", abs(float(error[worst])), f"{what} off", now.boxes_ego[actor, :2], now)


def _fit_heading(now: Instant, box_actor: Ints, box_error: Floats) -> Iterator[Snapshot]:
    """The box of a graded vehicle whose heading is most off, modulo a quarter turn."""
    owned = np.flatnonzero(box_actor != NO_ACTOR)
    if len(owned):
        worst = owned[np.abs(box_error[owned]).argmax()]
        error = np.degrees(box_error[worst])
        place = now.boxes_ego[now.actors.id == box_actor[worst], :2][0]
        what = f"the box fitted to vehicle {box_actor[worst]} is {error:+.1f}° off"
        yield Snapshot("fit_heading", abs(float(error)), what, place, now)


def _keep(kept: list[Snapshot], new: Snapshot) -> None:
    """Enter a snapshot, the worst first, unless a worse one is near in time."""
    time = new.now.frame.time
    near = [old for old in kept if abs(old.now.frame.time - time) < APART_S]
    if not any(old.badness >= new.badness for old in near):
        rest = [old for old in kept if old not in near]
        kept[:] = sorted([*rest, new], key=lambda snapshot: -snapshot.badness)[:PER_KIND]


def _row(snapshot: Snapshot) -> dict[str, npt.NDArray[np.generic]]:
    ego = snapshot.now.frame.ego
    values = (SNAPSHOT_KINDS.index(snapshot.kind), snapshot.badness, snapshot.what, *snapshot.place_ego)
    columns = (*values, *ego.pose_world, *ego.size[:2])
    return {name: np.array([value]) for name, value in zip(SNAPSHOTS, columns, strict=True)}


def _point_rows(now: Instant) -> dict[str, npt.NDArray[np.generic]]:
    x, y, _ = now.scan.points_ego.T
    return {"x_ego_m": x, "y_ego_m": y, "actor_id": now.truth.actor_id, "cause": now.truth.cause}
