"""True motion modes: intervals computed by hand, and the classifier against a naive twin."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.traffic import frames

from luxloop.sim.modes import ModeClassifier, ModeLimits
from luxloop.sim.scripted.motions import Arc, LaneChange, Static, StopAndGo, Straight
from luxloop.sim.scripted.script import ScriptedActor
from luxloop.sim.scripted.scripted_source import ScriptedSource, ScriptedTraffic
from luxloop.sim.world import Mode

STANDS, STEADY, ACCELERATES = Mode.STATIONARY, Mode.CONSTANT_VELOCITY, Mode.ACCELERATING

# Frame k is at 0.08 k s. The limits are the defaults: 0.5 and 0.3 m/s, 0.6 and 0.4 m/s^2.
SCRIPTED = {
    "static": ([Static("static")], [(0, STANDS)]),
    # 0.5 m/s^2 is below 0.6, not yet accelerating; after 0.8 m/s^2 it still is, as it is not below 0.4; 0.3 is below.
    # They begin at 2.04 s (frame 25.5), 4.04 s (50.5), 6.04 s (75.5) and 8.04 s (100.5).
    "straight": (
        [
            Straight("straight", 10.0, duration_s=2.04),
            Straight("straight", 10.0, 0.5, duration_s=2.0),
            Straight("straight", 11.0, 0.8, duration_s=2.0),
            Straight("straight", 12.6, 0.5, duration_s=2.0),
            Straight("straight", 13.6, 0.3),
        ],
        [(0, STEADY), (51, ACCELERATES), (101, STEADY)],
    ),
    # v = 5 (1 - cos(pi t / 4)), a = 10 pi / 8 sin(pi t / 4) = 3.927 sin(pi t / 4).
    # v >= 0.5: cos <= 0.90, t >= 4/pi 0.45103 = 0.5743 s, frame 7.2; a is 1.9 m/s^2 there.
    # a < 0.4: sin < 0.10186, t > 4 - 4/pi 0.10204 = 3.8701 s, frame 48.4.
    # |a| >= 0.6: |sin| >= 0.15279, t >= 4 + 4/pi 0.15339 = 4.1953 s, frame 52.4.
    # v < 0.3: cos > 0.94, t > 8 - 4/pi 0.34816 = 7.5567 s, frame 94.5.
    # It goes again at 8 + 4 = 12 s, frame 150, and moves 7.2 frames later.
    "stop-and-go": (
        [StopAndGo("stop-and-go", peak_speed_mps=10.0, go_s=8.0, stop_s=4.0)],
        [(0, STANDS), (8, ACCELERATES), (49, STEADY), (53, ACCELERATES), (95, STANDS), (158, ACCELERATES)],
    ),
    # v^2 / r = 100 / 125 = 0.8 m/s^2 from 2.04 s (frame 25.5), 100 / 200 = 0.5 (not below 0.4) up to 8.04 s (100.5).
    "arc": (
        [
            Straight("straight", 10.0, duration_s=2.04),
            Arc("arc", 10.0, 125.0, duration_s=4.0),
            Arc("arc", 10.0, -200.0, duration_s=2.0),
            Straight("straight", 10.0),
        ],
        [(0, STEADY), (26, ACCELERATES), (101, STEADY)],
    ),
    # a = 3.5 / 16 * 60 s (1 - s) (1 - 2 s) = 13.125 p with s = t / 4 s; p = -2 u (1/4 - u^2) with u = s - 1/2.
    # |a| >= 0.6: |p| >= 0.045714, from s = 0.05421 (0.217 s, frame 2.7) and from u = 0.09484 (2.379 s, 29.7).
    # |a| < 0.4: |p| < 0.030476, from u = -0.06190 (1.752 s, frame 21.9) and from s = 1 - 0.03383 (3.865 s, 48.3).
    "lane change": (
        [LaneChange("lane-change", speed_mps=20.0, offset_m=3.5, change_s=4.0)],
        [(0, STEADY), (3, ACCELERATES), (22, STEADY), (30, ACCELERATES), (49, STEADY)],
    ),
}


def changes(modes):
    """Return the frames at which a sequence of modes changes, with the new mode, including the first."""
    return [(k, mode) for k, mode in enumerate(modes) if k == 0 or mode != modes[k - 1]]


def test_modes_of_scripted_motions_match_intervals_computed_by_hand():
    actors = [ScriptedActor(0.0, 5.0 * k, motion=motion) for k, (motion, _) in enumerate(SCRIPTED.values())]
    source = ScriptedSource(ScriptedTraffic(actor=actors), Path(), range_m=1000.0)
    modes = np.array([frame.actors.mode for frame in frames(source, 160)])
    assert modes.dtype == np.uint8
    for column, (name, (_, expected)) in zip(modes.T, SCRIPTED.items(), strict=True):
        assert changes(column.tolist()) == expected, name


def classified(classifier, *rows):
    """Return the modes of one frame of (id, speed, acceleration)."""
    table = np.array(rows, dtype=np.float64).reshape(-1, 3)
    towards = np.array([[0.6, -0.8]])
    return classifier.modes(
        table[:, 0].astype(np.int64), table[:, 1:2] * towards, table[:, 2:] * towards[:, ::-1]
    ).tolist()


@pytest.mark.parametrize(
    ("speed", "acceleration", "mode"),
    # the middles: 0.4 m/s and 0.5 m/s^2
    [(0.39, 9.0, STANDS), (0.41, 0.49, STEADY), (0.41, 0.51, ACCELERATES)],
)
def test_a_new_actor_is_classified_by_the_middle_of_each_pair(speed, acceleration, mode):
    assert classified(ModeClassifier(ModeLimits()), (1, speed, acceleration)) == [mode]


def test_an_actor_keeps_its_mode_between_limits_and_loses_it_by_absence():
    classifier = ModeClassifier(ModeLimits())
    assert classified(classifier, (3, 5.0, 1.0), (8, 0.0, 0.0)) == [ACCELERATES, STANDS]
    assert classified(classifier, (3, 0.35, 0.45), (8, 0.45, 0.0)) == [ACCELERATES, STANDS]
    # 8 has left; 5 and 9 are new and must not be confused with 3 and 8
    assert classified(classifier, (3, 0.35, 0.45), (5, 0.35, 0.45), (9, 0.45, 0.45)) == [ACCELERATES, STANDS, STEADY]
    assert classified(classifier, (8, 0.45, 0.0)) == [STEADY]
    assert classified(classifier) == []
    assert classified(classifier, (3, 0.35, 0.45)) == [STANDS]


def test_an_acceleration_from_standstill_counts_from_the_first_motion():
    classifier = ModeClassifier(ModeLimits())
    classified(classifier, (1, 0.0, 0.7))
    assert classified(classifier, (1, 0.4, 0.5)) == [STANDS]
    assert classified(classifier, (1, 0.6, 0.5)) == [ACCELERATES]


def slow_modes(history, limits):
    """Return the last mode of one actor from its history of (speed, acceleration), by the definition."""
    moves = accelerates = None
    for speed, acceleration in history:
        if moves is None:
            moves = speed >= (limits.moves_from_mps + limits.stands_below_mps) / 2
            accelerates = acceleration >= (limits.accelerates_from_mps2 + limits.steady_below_mps2) / 2
            continue
        moves = speed >= limits.stands_below_mps if moves else speed >= limits.moves_from_mps
        threshold = limits.steady_below_mps2 if accelerates else limits.accelerates_from_mps2
        accelerates = acceleration >= threshold
    return (ACCELERATES if accelerates else STEADY) if moves else STANDS


# Values and limits are multiples of 1/8: every comparison is exact, also at the limits.
EIGHTHS = st.integers(0, 12).map(lambda n: n / 8)
FRAME = st.dictionaries(st.integers(0, 6), st.tuples(EIGHTHS, EIGHTHS))


@given(st.lists(FRAME, min_size=1, max_size=12))
def test_the_classifier_equals_its_naive_twin_with_actors_appearing_and_leaving(run):
    limits = ModeLimits(1.0, 0.5, 0.75, 0.25)
    classifier, history = ModeClassifier(limits), {}
    for frame in run:
        history = {id: [*history.get(id, []), frame[id]] for id in sorted(frame)}
        value = np.array([frame[id] for id in sorted(frame)]).reshape(-1, 2)
        flat = np.zeros(len(value))
        found = classifier.modes(
            np.array(sorted(frame), dtype=np.int64),
            np.column_stack([value[:, 0], flat]),
            np.column_stack([flat, -value[:, 1]]),
        )
        assert found.tolist() == [slow_modes(history[id], limits) for id in sorted(frame)]


@pytest.mark.parametrize(
    "wrong",
    [
        {"stands_below_mps": 0.6},
        {"stands_below_mps": 0.0},
        {"moves_from_mps": float("nan")},
        {"steady_below_mps2": 0.7},
        {"accelerates_from_mps2": -1.0},
    ],
)
def test_limits_in_the_wrong_order_are_rejected_in_one_line(wrong):
    with pytest.raises(ValueError, match=rf"^[^\n]*{next(iter(wrong))}[^\n]*$"):
        ModeLimits(**wrong)
