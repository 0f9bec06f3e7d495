"""Remarks on a run, from tracks and verdicts alone."""

from dataclasses import replace

import numpy as np
import pytest
from support.drive import Step, drive

from scenarios.recording.events import LOST_S, Event, EventFinder
from sensor_model.truth import NO_ACTOR
from tracker.records import Status

NEW, SURE, GONE, DEAD = Status


@pytest.fixture
def template() -> Step:
    return next(drive(1))


def frame(template: Step, time: float, tracks: dict[int, tuple[Status, int]]) -> tuple:
    """Arguments of `EventFinder.update`: by track id its status and the actor that it follows."""
    rows = np.arange(len(tracks))
    records = {
        name: values[rows]
        for name in template.tracks.__slots__
        if name not in ("id", "status") and (values := getattr(template.tracks, name)) is not None
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


def told(template: Step, *frames: tuple[float, dict[int, tuple[Status, int]]]) -> list[list[Event]]:
    finder = EventFinder()
    return [finder.update(*frame(template, time, tracks)) for time, tracks in frames]


def test_a_life(template: Step) -> None:
    # Fails when a state change is missed or told twice.
    lost = LOST_S + 0.1
    assert told(
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
        [Event("WARN", "track 7 lost sight of flow.1, coasting")],
        [],
        [Event("INFO", "track 7 back after 0.7 s, on flow.1")],
        [Event("INFO", "track 7 dead, was on flow.1")],
        [],
    ]


def test_a_short_gap_and_a_tentative_life_are_not_remarked_on(template: Step) -> None:
    # Fails when every scan without a fit floods the log.
    events = told(
        template,
        (0.0, {1: (SURE, 100), 2: (NEW, 101)}),
        (0.1, {1: (GONE, 100), 2: (NEW, 101)}),
        (0.2, {1: (SURE, 100)}),
    )
    assert events == [[Event("INFO", "track 1 confirmed on flow.0")], [], []]


def test_a_track_that_is_reported_dead_is_told_once(template: Step) -> None:
    # Fails when only missing rows count as death.
    events = told(template, (0.0, {1: (SURE, 100)}), (0.1, {1: (DEAD, NO_ACTOR)}), (0.2, {}))
    assert events[1:] == [[Event("INFO", "track 1 dead, was on flow.0")], []]


def test_an_id_switch_is_told_when_an_actor_gets_another_track(template: Step) -> None:
    # Bernardin and Stiefelhagen 2008, section 2.1.2: a mismatch counts when an object is matched to another
    # hypothesis than last, however long ago; a second track beside the first is not one.
    events = told(
        template,
        (0.0, {2: (SURE, 100)}),
        (0.1, {1: (SURE, 100), 2: (SURE, 100)}),
        (0.2, {1: (NEW, 101), 2: (GONE, NO_ACTOR)}),
        (0.3, {1: (SURE, 100)}),
        (0.4, {1: (SURE, 100)}),
    )
    switches = [[event.text for event in frame if event.level == "ERROR"] for frame in events]
    assert switches == [[], [], [], ["flow.0 switched from track 2 to track 1"], []]


def test_a_track_on_nothing_is_named_so(template: Step) -> None:
    # Fails when the last actor of the list is taken for "no actor" (id -1 used as an index).
    assert told(template, (0.0, {3: (SURE, NO_ACTOR)})) == [[Event("INFO", "track 3 confirmed on nothing real")]]
