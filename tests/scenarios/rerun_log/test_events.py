"""Events of a run, from tracks and grades alone."""

from dataclasses import replace

import numpy as np
import pytest
from support.drive import Step, drive

from luxloop.scenarios.rerun_log.events import LOST_S, Event, EventFinder
from luxloop.sensor_model.truth import NO_ACTOR
from luxloop.tracker.records import Status

NEW, SURE, GONE, DEAD = Status


@pytest.fixture
def template() -> Step:
    return next(drive(1))


def frame(template: Step, time: float, tracks: dict[int, tuple[Status, int]]) -> tuple:
    """Arguments of `EventFinder.update`, from the status and followed actor of each track id."""
    rows = np.arange(len(tracks))
    records = {
        name: values[rows]
        for name in template.tracks.__slots__
        if name not in ("id", "status", "models") and (values := getattr(template.tracks, name)) is not None
    }
    return (
        replace(template.frame, time=time),
        replace(
            template.tracks,
            id=np.array(list(tracks), dtype=np.int64),
            status=np.array([status for status, _ in tracks.values()], dtype=np.uint8),
            **records,
        ),
        replace(template.grade, track_actor=np.array([actor for _, actor in tracks.values()], dtype=np.int64)),
    )


def events_of(template: Step, *frames: tuple[float, dict[int, tuple[Status, int]]]) -> list[list[Event]]:
    finder = EventFinder()
    return [finder.update(*frame(template, time, tracks)) for time, tracks in frames]


def test_life_cycle_of_a_track(template: Step) -> None:
    # Fails when a state change is missed or reported twice.
    lost = LOST_S + 0.1
    assert events_of(
        template,
        (0.0, {7: (NEW, 101)}),
        (0.1, {7: (SURE, 101)}),
        (0.2, {7: (SURE, 101)}),
        (0.3, {7: (GONE, NO_ACTOR)}),
        (0.2 + lost, {7: (GONE, NO_ACTOR)}),
        (0.3 + lost, {7: (GONE, NO_ACTOR)}),
        (0.4 + lost, {7: (SURE, 101)}),
        (0.5 + lost, {}),
        (0.6 + lost, {}),
    ) == [
        [],
        [Event("INFO", "track 7 confirmed on flow.1")],
        [],
        [],
        [Event("WARN", "track 7 lost flow.1, coasting")],
        [],
        [Event("INFO", "track 7 back after 0.7 s, on flow.1")],
        [Event("INFO", "track 7 terminated, was on flow.1")],
        [],
    ]


def test_short_gaps_and_tentative_tracks_have_no_events(template: Step) -> None:
    # Fails when every scan without a fit floods the log.
    events = events_of(
        template,
        (0.0, {1: (SURE, 100), 2: (NEW, 101)}),
        (0.1, {1: (GONE, 100), 2: (NEW, 101)}),
        (0.2, {1: (SURE, 100)}),
    )
    assert events == [[Event("INFO", "track 1 confirmed on flow.0")], [], []]


def test_dead_track_has_one_termination_event(template: Step) -> None:
    # Fails when only missing rows count as terminated.
    events = events_of(template, (0.0, {1: (SURE, 100)}), (0.1, {1: (DEAD, NO_ACTOR)}), (0.2, {}))
    assert events[1:] == [[Event("INFO", "track 1 terminated, was on flow.0")], []]


def test_id_switch_event_when_an_actor_gets_another_track(template: Step) -> None:
    # Bernardin and Stiefelhagen 2008, section 2.1.2: a mismatch is a match of an object with another hypothesis than
    # its last one, however long ago. A second track beside the first is not a mismatch.
    events = events_of(
        template,
        (0.0, {2: (SURE, 100)}),
        (0.1, {1: (SURE, 100), 2: (SURE, 100)}),
        (0.2, {1: (NEW, 101), 2: (GONE, NO_ACTOR)}),
        (0.3, {1: (SURE, 100)}),
        (0.4, {1: (SURE, 100)}),
    )
    switches = [[event.text for event in frame if event.level == "ERROR"] for frame in events]
    assert switches == [[], [], [], ["flow.0 switched from track 2 to track 1"], []]


def test_track_without_actor_is_confirmed_on_no_actor(template: Step) -> None:
    # Fails when the last actor of the list is taken for "no actor" (id -1 used as an index).
    assert events_of(template, (0.0, {3: (SURE, NO_ACTOR)})) == [[Event("INFO", "track 3 confirmed on no actor")]]
