"""Events of a run for the log of a recording: track confirmation, loss, reacquisition, termination, and id switches."""

from dataclasses import dataclass, field
from typing import Literal

from luxloop.scenarios.grading.frame_truth import FrameGrade
from luxloop.sensor_model.truth import NO_ACTOR
from luxloop.sim.world import WorldFrame
from luxloop.tracker.records import Status, Tracks

LOST_S = 0.4
"""Least duration of coasting that is an event [s]. Single scans without a fit are common."""


@dataclass(frozen=True, slots=True)
class Event:
    """An event: INFO for the normal life cycle of a track, WARN for a lost target, ERROR for a tracker error."""

    level: Literal["INFO", "WARN", "ERROR"]
    text: str


@dataclass(slots=True)
class _TrackState:
    """State of a track since its confirmation."""

    confirmed_at: float
    """Last time with status confirmed [s]."""
    actor: str = "no actor"
    """Name of the actor that it followed last."""
    lost: bool = False
    """True after the event of its loss."""


@dataclass(slots=True)
class EventFinder:
    """Finds the events of a run by comparison of consecutive frames.

    Tentative tracks have no events, because most of them last one or two frames only.
    """

    _states: dict[int, _TrackState] = field(default_factory=dict)
    """State by track id."""
    _follower: dict[int, int] = field(default_factory=dict)
    """Last confirmed track that followed each actor, by actor id."""

    def update(self, frame: WorldFrame, tracks: Tracks, grade: FrameGrade) -> list[Event]:
        """Return the events of a frame: those of each track in the order of `tracks`, terminations, id switches."""
        names = dict(zip(frame.actors.id.tolist(), frame.actors.name.tolist(), strict=True))
        rows = zip(tracks.id.tolist(), tracks.status, grade.track_actor.tolist(), strict=True)
        events = [self._of_track(track, status, names.get(actor), frame.time) for track, status, actor in rows]
        found = [event for event in events if event is not None]
        return found + self._terminations(tracks) + self._switches(tracks, grade, names)

    def _of_track(self, track: int, status: int, actor: str | None, time: float) -> Event | None:
        known = self._states.get(track)
        if status == Status.CONFIRMED:
            self._states[track] = state = known or _TrackState(time)
            new, lost, gap = known is None, state.lost, time - state.confirmed_at
            state.confirmed_at, state.lost, state.actor = time, False, actor or state.actor
            if new:
                return Event("INFO", f"track {track} confirmed on {state.actor}")
            if lost:
                return Event("INFO", f"track {track} back after {gap:.1f} s, on {state.actor}")
        elif known and not known.lost and status == Status.COASTING and time - known.confirmed_at >= LOST_S:
            known.lost = True
            return Event("WARN", f"track {track} lost {known.actor}, coasting")
        return None

    def _terminations(self, tracks: Tracks) -> list[Event]:
        alive = set(tracks.id[tracks.status != Status.DEAD].tolist())
        dead = [track for track in self._states if track not in alive]
        return [Event("INFO", f"track {track} terminated, was on {self._states.pop(track).actor}") for track in dead]

    def _switches(self, tracks: Tracks, grade: FrameGrade, names: dict[int, str]) -> list[Event]:
        """Return the mismatches of CLEAR MOT: an actor is followed by another track than the last one."""
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
