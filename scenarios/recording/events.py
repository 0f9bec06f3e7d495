"""What one would remark on while watching a run: tracks that appear, get lost, return or die, and id switches."""

from dataclasses import dataclass, field
from typing import Literal

from scenarios.grading.frame_grade import FrameGrade
from sensor_model.truth import NO_ACTOR
from sim.world import WorldFrame
from tracker.records import Status, Tracks

LOST_S = 0.4
"""Shorter gaps are not remarked on: single scans without a fit are everyday business [s]."""


@dataclass(frozen=True, slots=True)
class Event:
    """One remark. INFO is business as usual, WARN a lost target, ERROR a mistake of the tracker."""

    level: Literal["INFO", "WARN", "ERROR"]
    text: str


@dataclass(slots=True)
class _Life:
    """What is remembered of a track that was confirmed once."""

    seen_at: float
    """Time it was last confirmed [s]."""
    actor: str = "nothing real"
    """Name of the actor it followed last."""
    lost: bool = False


@dataclass(slots=True)
class EventFinder:
    """Finds the events of a run by comparing each frame with the one before.

    Tentative tracks are not remarked on: most of them live for a frame or two.
    """

    _lives: dict[int, _Life] = field(default_factory=dict)
    _follower: dict[int, int] = field(default_factory=dict)
    """Per actor id, the confirmed track that followed it last."""

    def update(self, frame: WorldFrame, tracks: Tracks, grade: FrameGrade) -> list[Event]:
        """Return the events of this frame: of each track, in the order of `tracks`, then deaths, then id switches."""
        names = dict(zip(frame.actors.id.tolist(), frame.actors.name.tolist(), strict=True))
        rows = zip(tracks.id.tolist(), tracks.status, grade.track_actor.tolist(), strict=True)
        events = [self._of_track(track, status, names.get(actor), frame.time) for track, status, actor in rows]
        found = [event for event in events if event is not None]
        return found + self._deaths(tracks) + self._switches(tracks, grade, names)

    def _of_track(self, track: int, status: int, actor: str | None, time: float) -> Event | None:
        life = self._lives.get(track)
        if status == Status.CONFIRMED:
            self._lives[track] = now = life or _Life(time)
            born, lost, gap = life is None, now.lost, time - now.seen_at
            now.seen_at, now.lost, now.actor = time, False, actor or now.actor
            if born:
                return Event("INFO", f"track {track} confirmed on {now.actor}")
            if lost:
                return Event("INFO", f"track {track} back after {gap:.1f} s, on {now.actor}")
        elif life and not life.lost and status == Status.COASTING and time - life.seen_at >= LOST_S:
            life.lost = True
            return Event("WARN", f"track {track} lost sight of {life.actor}, coasting")
        return None

    def _deaths(self, tracks: Tracks) -> list[Event]:
        living = set(tracks.id[tracks.status != Status.DEAD].tolist())
        dead = [track for track in self._lives if track not in living]
        return [Event("INFO", f"track {track} dead, was on {self._lives.pop(track).actor}") for track in dead]

    def _switches(self, tracks: Tracks, grade: FrameGrade, names: dict[int, str]) -> list[Event]:
        """Return CLEAR MOT's mismatches: an actor is followed by another track than the last that followed it."""
        follows = (tracks.status == Status.CONFIRMED) & (grade.track_actor != NO_ACTOR)
        followers: dict[int, list[int]] = {}
        for actor, track in zip(grade.track_actor[follows].tolist(), tracks.id[follows].tolist(), strict=True):
            followers.setdefault(actor, []).append(track)
        events = []
        for actor, now in followers.items():
            before = self._follower.get(actor)
            if before in now:
                continue
            self._follower[actor] = now[0]
            if before is not None:
                events.append(Event("ERROR", f"{names[actor]} switched from track {before} to track {now[0]}"))
        return events
