"""Metrics of people and riders, on cases computed by hand."""

import numpy as np
import pytest
from support.frames import Body, Estimate, Scripted, drive, follow, grade_run

from luxloop.sim.world import Kind

FRAMES = 10
PERSON_SIZE, RIDER_SIZE = (0.3, 0.48, 1.72), (1.7, 0.65, 1.7)


def person(index, y=8.0, actor=0, **changes):
    x, _ = drive(-1.0, y, 0.0, 1.4, index)
    return Body(actor, x, y, 0.0, 1.4, size=PERSON_SIZE, kind=Kind.PEDESTRIAN, **changes)


def rider(index, y=-8.0, actor=1, **changes):
    x, _ = drive(-1.0, y, 0.0, 5.0, index)
    return Body(actor, x, y, 0.0, 5.0, size=RIDER_SIZE, kind=Kind.BICYCLE, **changes)


def run(scene, follower):
    """Grade a tracker that reports `follower(index, bodies)` in each frame."""
    script = [follower(index, bodies) for index, bodies in enumerate(scene)]
    return grade_run(scene, Scripted(script))[0]


def of(metrics, group, *names):
    return [metrics[f"{group}.{name}"].value for name in names]


BOTH = [[person(i), rider(i)] for i in range(FRAMES)]
ALONE = [[person(i)] for i in range(FRAMES)]


def test_perfect_tracks_of_both_classes():
    metrics = run(BOTH, lambda _, bodies: [follow(body, small=True) for body in bodies])
    for group in ("people", "riders"):
        assert of(metrics, group, "hota", "deta", "assa", "mota", "idf1") == pytest.approx([1.0] * 5)
        assert of(metrics, group, "id_switches", "fragments", "missed", "false") == [0, 0, 0, 0]
        assert of(metrics, group, "position_abs_mean_m", "speed_abs_mean_mps") == pytest.approx([0, 0], abs=1e-9)
        assert of(metrics, group, "observations", "time_to_confirm_s", "never_confirmed") == [FRAMES, 0, 0]
    assert metrics["track.hota"].value is None
    assert metrics["track.false"].value is None


@pytest.mark.parametrize(
    ("offset_m", "hota", "missed", "false"),
    # Similarities of 0.75, 0.45 and 0: 15, 9 and none of the 19 thresholds 0.05, 0.10 ... 0.95; a hit needs 0.5.
    [(0.5, 15 / 19, 0, 0), (1.1, 9 / 19, FRAMES, FRAMES), (2.1, 0.0, FRAMES, FRAMES)],
)
def test_distance_decides(offset_m, hota, missed, false):
    metrics = run(ALONE, lambda _, bodies: [follow(body, y=body.y + offset_m, small=True) for body in bodies])
    assert of(metrics, "people", "hota", "missed", "false") == pytest.approx([hota, missed, false])
    if not missed:
        assert of(metrics, "people", "position_abs_mean_m") == pytest.approx([offset_m])


def test_small_track_on_nothing_is_no_false_vehicle():
    phantom = Estimate(7, 0.0, 25.0, size=(0.5, 0.5), small=True)
    metrics = run(BOTH, lambda _, bodies: [*(follow(body, small=True) for body in bodies), phantom])
    assert of(metrics, "people", "false") == of(metrics, "riders", "false") == [FRAMES]
    assert metrics["track.false"].value is None  # no track of a vehicle


def test_vehicle_on_nothing_is_no_false_person():
    phantom = Estimate(7, 0.0, 25.0, small=False)
    metrics = run(BOTH, lambda _, bodies: [*(follow(body, small=True) for body in bodies), phantom])
    assert of(metrics, "people", "false") == [0]
    assert metrics["track.false"].value == FRAMES


def test_small_track_on_a_vehicle_is_a_false_vehicle():
    scene = [[*bodies, Body(5, 0.0, 20.0)] for bodies in ALONE]
    piece = Estimate(7, 1.5, 20.0, size=(0.5, 0.5), small=True)
    metrics = run(scene, lambda _, bodies: [follow(bodies[0], small=True), follow(bodies[1], small=False), piece])
    assert metrics["track.false"].value == FRAMES
    assert of(metrics, "people", "false", "missed") == [0, 0]


def test_person_called_a_vehicle_is_missed():
    metrics = run(ALONE, lambda _, bodies: [follow(body, small=False) for body in bodies])
    assert of(metrics, "people", "missed", "called_vehicle_share", "false") == [FRAMES, 1.0, 0]


def test_tracker_without_classes_can_be_right_but_has_no_false_people():
    metrics = run(ALONE, lambda _, bodies: [*map(follow, bodies), Estimate(7, 0.0, 25.0)])
    assert of(metrics, "people", "hota", "missed", "false", "called_vehicle_share") == [1.0, 0, None, None]
    assert "does not distinguish" in metrics["people.false"].reason
    assert metrics["track.false"].value == FRAMES


def test_second_track_on_a_person_is_false_for_people_only():
    def twice(_, bodies):
        first = follow(bodies[0], small=True)
        return [first, follow(bodies[0], 9, y=bodies[0].y + 0.8, small=True), follow(bodies[1], small=True)]

    metrics = run(BOTH, twice)
    assert of(metrics, "people", "false") == [FRAMES]
    assert of(metrics, "riders", "false") == [0]


def test_id_that_changes_once():
    metrics = run(ALONE, lambda i, bodies: [follow(bodies[0], 0 if i < 5 else 1, small=True)])
    # Detection is perfect, the association of every frame is 5 / 10 (Luiten et al. 2021).
    assert of(metrics, "people", "hota", "id_switches", "idf1") == pytest.approx([np.sqrt(0.5), 1, 0.5])


@pytest.mark.parametrize("changes", [{"points": 5}, {"y": 41.0}], ids=["five points", "41 m away"])
def test_ungraded_person_is_neither_right_nor_wrong(changes):
    scene = [[person(i, **changes), rider(i)] for i in range(FRAMES)]
    metrics = run(scene, lambda _, bodies: [follow(body, small=True) for body in bodies])
    assert of(metrics, "people", "observations", "hota") == [0, None]
    assert of(metrics, "riders", "false", "hota") == [0, 1.0]


def test_speed_and_velocity_errors():
    metrics = run(ALONE, lambda _, bodies: [follow(bodies[0], velocity=(0.0, 1.0), small=True)])
    # True velocity (1.4, 0): the speeds differ by 0.4, the vectors by sqrt(1.4^2 + 1^2).
    names = ("speed_abs_mean_mps", "velocity_abs_mean_mps")
    assert of(metrics, "people", *names) == pytest.approx([0.4, np.hypot(1.4, 1.0)])


def test_confirmation_after_three_frames():
    metrics = run(ALONE, lambda i, bodies: [follow(bodies[0], small=True)] if i >= 3 else [])
    assert of(metrics, "people", "time_to_confirm_s", "missed") == pytest.approx([0.24, 3])
